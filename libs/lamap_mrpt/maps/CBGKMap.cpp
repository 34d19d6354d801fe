#include <lamap_mrpt/maps/CBGKMap.h>

#include <lamap_mrpt/files/grid_content.h>
#include <lamap_mrpt/files/map_file.h>
#include <lamap_mrpt/maps/learner_map_impl.h>

#include <memory>
#include <stdexcept>

namespace lamap
{
template class LearnerMap<BgkLearner>;

IMPLEMENTS_SERIALIZABLE(CBGKMap, mrpt::maps::CMetricMap, lamap)

namespace
{
const MapRegistration<BgkLearner> bgkRegistration;

/// α and β of another map as prior.
std::shared_ptr<const BgkMap> loadPrior(const std::string& path)
{
  const auto map = loadMapFile(path);
  const auto bgk = std::dynamic_pointer_cast<const CBGKMap>(map);
  if (!bgk)
    throw std::invalid_argument("creationOpts.priorMap = \"" + path + "\" is a " +
                                map->GetRuntimeClass()->className + "; legal is a file of a lamap::CBGKMap");
  return std::make_shared<const BgkMap>(bgk->core());
}

/// A prior map may have a prior map; a file in which this does not end is not one of ours.
constexpr int kMaxPriorDepth = 16;

void readAtDepth(BgkMap& map, ByteReader& in, int depth)
{
  if (depth > kMaxPriorDepth) in.fail("prior maps are nested too deep");
  map.restoreEvidence(readGrid(map.evidence(), map.structure().planarLayer(), in));
  if (!in.number<bool>()) return;
  CBGKMap::TCreationOptions options;
  options.read(in);
  auto prior = std::make_shared<BgkMap>(options);
  readAtDepth(*prior, in, depth + 1);
  map.setPriorMap(std::move(prior));
}
}  // namespace

const OptionTable& BgkLearner::Creation::optionTable()
{
  static const OptionTable table = []
  {
    OptionTableOf<Creation> all("creationOpts");
    return all.include<BgkStructure>().add(
        "priorMap", &Creation::priorMap, plain(),
        "map file of a BGK map whose pseudo-counts are the prior where it has evidence; stored in the "
        "map");
  }();
  return table;
}

BgkMap BgkLearner::make(const Creation& creation)
{
  BgkMap map(creation);
  if (!creation.priorMap.empty()) map.setPriorMap(loadPrior(creation.priorMap));
  return map;
}

void BgkLearner::write(const BgkMap& map, ByteWriter& out)
{
  writeGrid(map.evidence(), out);
  out.number(map.priorMap() != nullptr);
  if (!map.priorMap()) return;
  CBGKMap::TCreationOptions options;
  static_cast<BgkStructure&>(options) = map.priorMap()->structure();
  options.write(out);
  write(*map.priorMap(), out);
}

void BgkLearner::read(BgkMap& map, ByteReader& in, uint8_t /*version*/)
{
  readAtDepth(map, in, 0);
}

void CBGKMap::merge(const CBGKMap& other)
{
  map().merge(other.core(), insertionOptions.thresholds);
  contentChanged();
}

std::vector<CLearnedMap::Fact> CBGKMap::facts() const
{
  double alpha = 0;
  double beta = 0;
  std::vector<Fact> ofCells = cellFacts(
      [&](const CellIndex& cell, const CellEstimate&)
      {
        const CellSums sums = core().evidence().at(cell);
        alpha += static_cast<double>(sums.first) * kEvidenceUnit;
        beta += static_cast<double>(sums.second) * kEvidenceUnit;
      });
  std::vector<Fact> own{{"blocks", core().evidence().blockCount()},
                        {"evidence for occupied", alpha, "pseudo-counts"},
                        {"evidence for free", beta, "pseudo-counts"}};
  if (core().priorMap())
    own.push_back({"blocks of the prior map", core().priorMap()->evidence().blockCount()});
  return factsWith(std::move(ofCells), own);
}

void CBGKMap::updateVoxel(double x, double y, double z, bool occupied)
{
  const double scale = insertionOptions.kernelScale;
  map().addEvidence(addressableCell("updateVoxel", x, y, z), occupied ? scale : 0.0,
                    occupied ? 0.0 : insertionOptions.freeWeight * scale, insertionOptions.thresholds);
  contentChanged();
}

}  // namespace lamap
