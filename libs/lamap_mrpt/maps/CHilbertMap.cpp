#include <lamap_mrpt/maps/CHilbertMap.h>

#include <lamap_core/hilbert/state.h>
#include <lamap_mrpt/files/hilbert_map_content.h>
#include <lamap_mrpt/maps/learner_map_impl.h>

#include <stdexcept>

namespace lamap
{
template class LearnerMap<HilbertLearner>;

IMPLEMENTS_SERIALIZABLE(CHilbertMap, mrpt::maps::CMetricMap, lamap)

namespace
{
const MapRegistration<HilbertLearner> hilbertRegistration;
}  // namespace

void HilbertLearner::write(const HilbertMap& map, ByteWriter& out)
{
  writeHilbertState(map.state(), out);
}

void HilbertLearner::read(HilbertMap& map, ByteReader& in, uint8_t version)
{
  map.restore(readHilbertState(in, version));
}

std::optional<double> CHilbertMap::expectedLogoddsAt(const mrpt::math::TPoint3D& point_map,
                                                     const mrpt::math::CMatrixDouble33& covariance) const
{
  return core().logoddsAt(Eigen::Vector3d(point_map.x, point_map.y, point_map.z), covariance.asEigen());
}

void CHilbertMap::visitCells(const CellVisitor& visitor) const
{
  core().visitCells(insertionOptions.thresholds, visitor, threadCount());
}

std::vector<CLearnedMap::Fact> CHilbertMap::facts() const
{
  std::vector<Fact> own{{"weights", core().weightCount()}};
  if (core().structure().training == HilbertTraining::Batch)
    own.push_back({"training points", core().trainingPointCount()});
  return factsWith(cellFacts(), own);
}

void CHilbertMap::updateVoxel(double /*x*/, double /*y*/, double /*z*/, bool /*occupied*/)
{
  throw std::logic_error(
      "updateVoxel: the cells of a lamap::CHilbertMap are a view of its model and cannot be written; insert "
      "observations or rays, or use a lamap::CBGKMap or lamap::COverlappingHilbertMap");
}

}  // namespace lamap
