// Log-odds at regular points and at single ones, against the sum over all centres.
#include <gtest/gtest.h>
#include <lamap_core/features/compact_sum.h>
#include <lamap_core/features/packed_sites.h>
#include <support/hilbert_oracle.h>
#include <support/seeded_scans.h>

#include <cmath>
#include <random>

namespace lamap::test
{
namespace
{
constexpr double kSpacing = 0.25;

struct Field
{
  HilbertLattice<float> lattice;
  std::vector<std::pair<CellIndex, float>> sites;

  void add(const CellIndex& site, float weight)
  {
    if (lattice.find(site) != nullptr) return;
    SiteSet::Bits bits{};
    const uint32_t offset = SiteSet::offsetOf(site);
    bits[offset / 64] = uint64_t{1} << (offset % 64);
    lattice.addSites(SiteSet::blockOf(site), bits, weight);
    sites.emplace_back(site, weight);
  }
  double sumAt(const Eigen::Vector3d& point, bool& reached) const
  {
    double sum = 0;
    reached = false;
    for (const auto& [site, weight] : sites)
    {
      const Eigen::Vector3d centre = kSpacing * Eigen::Vector3d(site.x + 0.5, site.y + 0.5, site.z + 0.5);
      const double k = oracleCompactKernel(point - centre, 14, 0.03);
      sum += k * static_cast<double>(weight);
      reached = reached || k > 1e-6;
    }
    return sum;
  }
};

const CompactSum kSum(CompactKernel(), kSpacing, false);

PackedSites packed(const HilbertLattice<float>& lattice)
{
  PackedSites sites;
  for (const BlockIndex& index : lattice.sortedBlocks())
  {
    const auto* block = lattice.find(index);
    sites.blocks.push_back(index);
    sites.bits.push_back(block->bits);
    sites.weights.insert(sites.weights.end(), block->weights.begin(), block->weights.end());
  }
  sites.number();
  return sites;
}

Field randomField(Random& random, const CellIndex& anchor, int count)
{
  Field field;
  for (int i = 0; i < count; ++i)
  {
    const float weight = random.chance(0.1) ? 0.0f : static_cast<float>(random.uniform(-4, 4));
    field.add({anchor.x + random.integer(-9, 9), anchor.y + random.integer(-9, 9),
               anchor.z + random.integer(-6, 6)},
              weight);
  }
  return field;
}

TEST(HilbertLattice, HoldsWhatWasAdded)
{
  for (unsigned seed = 1; seed <= 10; ++seed)
  {
    Random random(seed);
    const CellIndex anchor{random.integer(-100, 100), -3, 5};
    const Field field = randomField(random, anchor, 300);
    EXPECT_EQ(field.lattice.siteCount(), field.sites.size());
    for (const auto& [site, weight] : field.sites)
    {
      ASSERT_NE(field.lattice.find(site), nullptr);
      EXPECT_EQ(*field.lattice.find(site), weight);
    }
    const CellIndex low{anchor.x - 4, anchor.y - 7, anchor.z - 2}, high{anchor.x + 5, anchor.y, anchor.z + 6};
    SiteBox box;
    field.lattice.copyInto(low, high, box);
    for (int z = low.z; z <= high.z; ++z)
      for (int y = low.y; y <= high.y; ++y)
        for (int x = low.x; x <= high.x; ++x)
        {
          const float* weight = field.lattice.find(CellIndex{x, y, z});
          const size_t at = box.rowOf(y, z) + static_cast<size_t>(x - low.x);
          ASSERT_EQ(box.isSite[at] != 0, weight != nullptr);
          ASSERT_EQ(box.weights[at], weight != nullptr ? *weight : 0.0f);
        }
  }
}

TEST(CompactSumProperty, RegularAndSinglePointsEqualTheSumOverAllCentres)
{
  for (unsigned seed = 1; seed <= 12; ++seed)
  {
    SCOPED_TRACE(seed);
    Random random(seed);
    const CellIndex anchor{random.integer(-20, 20), random.integer(-20, 20), random.integer(-20, 20)};
    const Field field = randomField(random, anchor, random.pick<int>({1, 30, 900}));
    const Eigen::Vector3d origin = kSpacing * Eigen::Vector3d(anchor.x, anchor.y, anchor.z);
    const PackedSites sites = packed(field.lattice);
    RegularPoints points{random.inCube(1.5), random.pick<double>({0.1, 0.05, 0.37, 1.3}), {11, 9, 10}};
    std::vector<ReachedLogodds> block;
    kSum.atRegular(field.lattice, anchor, points, block);
    std::vector<Eigen::Vector3d> asList;
    for (int z = 0; z < 10; ++z)
      for (int y = 0; y < 9; ++y)
        for (int x = 0; x < 11; ++x)
          asList.push_back(points.first + points.step_m * Eigen::Vector3d(x, y, z));
    ASSERT_EQ(block.size(), asList.size());
    size_t unreached = 0;
    for (size_t i = 0; i < asList.size(); ++i)
    {
      bool reached = false;
      const double expected = field.sumAt(origin + asList[i], reached);
      ASSERT_NEAR(block[i].logodds, expected, 1e-4) << i;
      ASSERT_TRUE(block[i].reached || !reached) << i;
      if (!block[i].reached)
      {
        ++unreached;
        ASSERT_EQ(block[i].logodds, 0.0f);
        ASSERT_NEAR(expected, 0.0, 1e-5);
      }
      for (const ReachedLogodds& single :
           {kSum.at(field.lattice, anchor, asList[i]), kSum.at(sites, anchor, asList[i])})
      {
        ASSERT_EQ(single.logodds, block[i].logodds) << i;
        ASSERT_EQ(single.reached, block[i].reached) << i;
      }
    }
    EXPECT_GT(unreached, 0u);
  }
}

TEST(CompactSum, WeightsThatAreAllZeroStillReach)
{
  Field field;
  field.add({0, 0, 0}, 0.0f);
  EXPECT_TRUE(kSum.at(field.lattice, {}, {0.1, 0.1, 0.1}).reached);
  EXPECT_EQ(kSum.at(field.lattice, {}, {0.1, 0.1, 0.1}).logodds, 0.0f);
  EXPECT_FALSE(kSum.at(field.lattice, {}, {0.7, 0.1, 0.1}).reached);
}

TEST(CompactSumProperty, TheAnchorDoesNotMatter)
{
  Random random(11);
  const Field field = randomField(random, {}, 600);
  for (int i = 0; i < 300; ++i)
  {
    const Eigen::Vector3d point = random.inCube(2);
    const CellIndex by{random.integer(-40, 40), random.integer(-40, 40), random.integer(-40, 40)};
    const ReachedLogodds here = kSum.at(field.lattice, {}, point);
    const ReachedLogodds there =
        kSum.at(field.lattice, by, point - kSpacing * Eigen::Vector3d(by.x, by.y, by.z));
    ASSERT_EQ(here.logodds, there.logodds);
  }
}

// Expected log-odds at an uncertain point: Σ u·k̄ with the expected kernel, which is never more than its
// cutoff below what drawing gives.
TEST(CompactSum, UncertainPointsHaveExpectedLogodds)
{
  Random random(12);
  Field field = randomField(random, {}, 500);
  for (int trial = 0; trial < 20; ++trial)
  {
    const Eigen::Vector3d point = random.inCube(1.5);
    const Eigen::Matrix3d covariance =
        Eigen::Vector3d(random.uniform(0, 0.05), random.uniform(0, 0.05), random.uniform(0, 0.01))
            .asDiagonal();
    double expected = 0;
    const GaussianBlur blur(covariance, 14);
    for (const auto& [site, weight] : field.sites)
    {
      const Eigen::Vector3d d = point - kSpacing * Eigen::Vector3d(site.x + 0.5, site.y + 0.5, site.z + 0.5);
      expected += static_cast<double>(weight) *
                  std::max(0.0, blur.factor * std::exp(-14 * blur.squaredDistance(d)) - 0.03);
    }
    EXPECT_NEAR(kSum.at(field.lattice, {}, point, covariance).logodds, expected, 1e-4);
    EXPECT_NEAR(kSum.at(field.lattice, {}, point, Eigen::Matrix3d::Zero()).logodds,
                kSum.at(field.lattice, {}, point).logodds, 1e-4);
  }
  EXPECT_FALSE(kSum.at(field.lattice, {}, {0, 0, 0}, Eigen::Matrix3d::Identity() * 50).reached);
}

TEST(CompactSum, PlanarMapsLookAtOneLayerOfSites)
{
  Random random(13);
  Field field;
  for (int i = 0; i < 60; ++i)
    field.add({random.integer(-6, 6), random.integer(-6, 6), 0}, static_cast<float>(random.uniform(-2, 2)));
  const CompactSum sum(CompactKernel(), kSpacing, true);
  for (int i = 0; i < 200; ++i)
  {
    Eigen::Vector3d point = random.inCube(1.5);
    const ReachedLogodds is = sum.at(field.lattice, {}, point);
    point.z() = 0.5 * kSpacing;
    bool reached = false;
    ASSERT_NEAR(is.logodds, field.sumAt(point, reached), 1e-4);
    std::vector<ReachedLogodds> one;
    sum.atRegular(field.lattice, {}, {point, 1.0, {1, 1, 1}}, one);
    ASSERT_EQ(one[0].logodds, is.logodds);
  }
}
}  // namespace
}  // namespace lamap::test
