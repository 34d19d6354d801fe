#include <lamap_mrpt/maps/CGPMap.h>

#include <lamap_core/grid/cell_sums.h>
#include <lamap_mrpt/files/grid_content.h>
#include <lamap_mrpt/maps/learner_map_impl.h>

#include <algorithm>

namespace lamap
{
template class LearnerMap<GpLearner>;

IMPLEMENTS_SERIALIZABLE(CGPMap, mrpt::maps::CMetricMap, lamap)

namespace
{
const MapRegistration<GpLearner> gpRegistration;

/// Refuses a grid whose cells hold what no GP map of this kind could.
void requireSums(const GpMap& map, const ByteReader& in)
{
  const bool isBcm = map.structure().fusion == GpFusion::Bcm;
  for (const BlockIndex& index : map.evidence().sortedBlocks())
  {
    map.evidence().find(index)->visitLeaves(map.evidence().shape(),
                                            [&](uint32_t, uint32_t, const CellSums& evidence)
                                            {
                                              const auto precision = SignedSums::decoded(evidence.first);
                                              const bool fits =
                                                  isBcm ? precision && *precision >= 0 : !precision;
                                              if (!fits || !SignedSums::decoded(evidence.second))
                                                in.fail("the evidence of a cell is not that of its fusion");
                                            });
  }
}
}  // namespace

void GpLearner::write(const GpMap& map, ByteWriter& out)
{
  writeGrid(map.evidence(), out);
}

void GpLearner::read(GpMap& map, ByteReader& in, uint8_t /*version*/)
{
  map.restoreEvidence(readGrid(map.evidence(), map.structure().planarLayer(), in));
  requireSums(map, in);
}

void CGPMap::merge(const CGPMap& other)
{
  map().merge(other.core(), insertionOptions.thresholds);
  contentChanged();
}

std::vector<std::string> CGPMap::evidenceNames() const
{
  if (creationOptions().fusion == GpFusion::Bayes) return {"logodds"};
  return {"precision", "mean"};
}

std::vector<CLearnedMap::Fact> CGPMap::facts() const
{
  double least = core().structure().signalVariance;
  std::vector<Fact> ofCells = cellFacts([&](const CellIndex&, const CellEstimate& cell)
                                        { least = std::min(least, cell.variance.value_or(least)); });
  std::vector<Fact> own{{"blocks", core().evidence().blockCount()}};
  if (creationOptions().fusion == GpFusion::Bcm) own.push_back({"smallest variance of a cell", least});
  return factsWith(std::move(ofCells), own);
}

void CGPMap::updateVoxel(double x, double y, double z, bool occupied)
{
  map().addObservation(addressableCell("updateVoxel", x, y, z), occupied, insertionOptions.thresholds);
  contentChanged();
}

}  // namespace lamap
