// What is worked on side by side must come out as each by itself, to the bit, whatever the processor has.
#include <gtest/gtest.h>
#include <lamap_core/features/nystroem_rows.h>
#include <lamap_core/learning/sgd.h>
#include <lamap_core/math/portable_math.h>
#include <lamap_core/math/wide_floats.h>
#include <support/seeded_scans.h>

namespace lamap::test
{
namespace
{
template <int kLanes>
void expectEachByItself(Random& random)
{
  std::array<float, kLanes> exponents{};
  for (float& x : exponents) x = static_cast<float>(random.uniform(-100, 100));
  typename Wide<kLanes>::Floats wide;
  Wide<kLanes>::load(exponents.data(), wide);
  Wide<kLanes>::exp(wide);
  for (int i = 0; i < kLanes; ++i) ASSERT_EQ(wide[i], portableExp(exponents[static_cast<size_t>(i)]));
}

TEST(WideFloats, ExpEqualsEachByItself)
{
  Random random(4);
  for (int i = 0; i < 50000; ++i)
  {
    expectEachByItself<4>(random);
    expectEachByItself<8>(random);
  }
}

struct NystroemCase
{
  size_t components;
  std::array<std::vector<float>, 3> inducing;
  std::vector<double> inverse;

  NystroemCase(size_t m, Random& random) : components(m), inverse(m * m, 0.0)
  {
    for (std::vector<float>& ofAxis : inducing)
      for (size_t k = 0; k < m; ++k) ofAxis.push_back(static_cast<float>(random.uniform(-2, 2)));
    for (size_t j = 0; j < m; ++j)
      for (size_t k = 0; k <= j; ++k) inverse[j * m + k] = random.uniform(-5, 5);
  }
};

TEST(NystroemRows, EqualTheirDefinition)
{
  Random random(7);
  for (const size_t m : {1, 3, 15, 16, 17, 100, 130})
  {
    SCOPED_TRACE(m);
    const NystroemCase given(m, random);
    const NystroemRows rows(given.inducing, given.inverse, 3.0);
    std::vector<float> kernels(NystroemRows::kAtOnce * rows.stride());
    std::vector<float> features(kernels);
    for (const bool wide : {false, true})
    {
      if (wide && !hasAvx2()) continue;
      for (size_t p = 0; p < NystroemRows::kAtOnce; ++p)
      {
        const auto at = [&] { return static_cast<float>(random.uniform(-2, 2)); };
        const std::array<float, 3> point{at(), at(), at()};
        rows.kernelsOf(point, kernels.data() + p * rows.stride(), wide);
        for (size_t k = 0; k < m; ++k)
        {
          float squares = 0;
          for (size_t axis = 0; axis < 3; ++axis)
          {
            const float d = point[axis] - given.inducing[axis][k];
            squares += d * d;
          }
          ASSERT_EQ(kernels[p * rows.stride() + k], portableExp(-3.0f * squares)) << k;
        }
      }
      rows.featuresOf(kernels.data(), features.data(), wide);
      for (size_t p = 0; p < NystroemRows::kAtOnce; ++p)
        for (size_t j = 0; j < m; ++j)
        {
          float sum = 0;
          for (size_t k = 0; k <= j; ++k)
            sum += static_cast<float>(given.inverse[j * m + k]) * kernels[p * rows.stride() + k];
          ASSERT_EQ(features[p * rows.stride() + j], sum) << j;
        }
    }
  }
}

/// Rows with random features and one run a point. @param unused weights that no row has, after the others
FeatureRows randomRows(uint64_t seed, size_t points, int width, size_t unused)
{
  Random random(seed);
  const auto weights = static_cast<size_t>(width);
  std::vector<uint32_t> used(weights);
  for (size_t j = 0; j < weights; ++j) used[j] = static_cast<uint32_t>(j);
  FeatureRows rows;
  rows.reset(width, points, weights + unused, used);
  rows.setBias(static_cast<uint32_t>(width) - 2);
  for (size_t chunk = 0; chunk < rows.chunkCount(); ++chunk)
    for (size_t i = rows.firstPointOf(chunk); i < rows.endPointOf(chunk); ++i)
    {
      float* values = rows.addRun(chunk, 0);
      for (size_t j = 0; j < weights; ++j) values[j] = static_cast<float>(random.uniform(-1, 1));
      values[weights - 2] = 1.0f;
      rows.endPoint(chunk);
    }
  return rows;
}

TEST(Sgd, DenseRowsTeachTheSameAsOthers)
{
  Random random(11);
  for (const int width : {4, 8, 16, 20, 104, 108})
  {
    SCOPED_TRACE(width);
    constexpr size_t kPoints = 3000;
    const FeatureRows dense = randomRows(5, kPoints, width, 0);
    const FeatureRows sparse = randomRows(5, kPoints, width, 4);
    ASSERT_TRUE(dense.dense());
    ASSERT_FALSE(sparse.dense());
    std::vector<float> labels;
    std::vector<float> weights;
    for (size_t i = 0; i < kPoints; ++i)
    {
      labels.push_back(dense.valuesOf(i)[0] > 0.2f ? 1.0f : 0.0f);
      weights.push_back(static_cast<float>(random.uniform(0.5, 2)));
    }
    SgdOptions options;
    options.alpha = 1e-3;  // so much that weights are held at 0
    std::vector<float> ofDense(dense.weights(), 0.0f);
    std::vector<float> ofSparse(sparse.weights(), 0.0f);
    uint64_t time = trainSgd(dense, labels, weights, options, 0, ofDense);
    (void)trainSgd(dense, labels, weights, options, time, ofDense);
    time = trainSgd(sparse, labels, weights, options, 0, ofSparse);
    (void)trainSgd(sparse, labels, weights, options, time, ofSparse);
    ofSparse.resize(ofDense.size());
    EXPECT_EQ(ofDense, ofSparse);
    EXPECT_NE(ofDense[0], 0.0f);
  }
}

}  // namespace
}  // namespace lamap::test
