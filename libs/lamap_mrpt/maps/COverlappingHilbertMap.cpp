#include <lamap_mrpt/maps/COverlappingHilbertMap.h>

#include <lamap_mrpt/files/overlapping_map_content.h>
#include <lamap_mrpt/maps/learner_map_impl.h>
#include <lamap_mrpt/observations/isometry.h>

namespace lamap
{
template class LearnerMap<OverlappingLearner>;

IMPLEMENTS_SERIALIZABLE(COverlappingHilbertMap, mrpt::maps::CMetricMap, lamap)

namespace
{
const MapRegistration<OverlappingLearner> overlappingRegistration;
}  // namespace

void OverlappingLearner::write(const OverlappingHilbertMap& map, ByteWriter& out)
{
  writeOverlappingMap(map, out);
}

void OverlappingLearner::read(OverlappingHilbertMap& map, ByteReader& in, uint8_t version)
{
  readOverlappingMap(map, in, version);
}

void COverlappingHilbertMap::contentChanged()
{
  withPending_.reset();
  CLearnedMap::contentChanged();
}

std::shared_ptr<const OverlappingHilbertMap> COverlappingHilbertMap::whole() const
{
  // Nobody owns the map that is handed out where no scans wait.
  if (core().pending().scans.empty()) return {std::shared_ptr<void>(), &core()};
  return withPending_.get(
      [&]
      {
        auto trained = std::make_shared<OverlappingHilbertMap>(core());
        const auto withoutThem = [&](const std::exception& error)
        {
          MRPT_LOG_ERROR_STREAM("what is read of the map is without the "
                                << trained->pending().scans.size()
                                << " scans that wait for others: " << error.what());
          trained->dropPending();
        };
        try
        {
          trained->trainPending(insertionOptions, threadCount());
        }
        catch (const std::length_error& error)
        {
          withoutThem(error);
        }
        catch (const std::overflow_error& error)
        {
          withoutThem(error);
        }
        return trained;
      });
}

void COverlappingHilbertMap::merge(const COverlappingHilbertMap& other)
{
  map().merge(other.core(), insertionOptions.thresholds);
  contentChanged();
}

mrpt::poses::CPose3D COverlappingHilbertMap::modelPose(size_t model) const
{
  return poseOf(core().modelPose(model));
}

void COverlappingHilbertMap::setModelPose(size_t model, const mrpt::poses::CPose3D& sensor_map)
{
  map().setModelPose(model, isometryOf(sensor_map), insertionOptions.thresholds, threadCount());
  contentChanged();
}

std::optional<CellEstimate> COverlappingHilbertMap::estimateAt(const mrpt::math::TPoint3D& point_map) const
{
  const Eigen::Vector3d point(point_map.x, point_map.y, point_map.z);
  return core().structure().keepModels ? whole()->continuousAt(point, insertionOptions.thresholds)
                                       : whole()->at(point, insertionOptions.thresholds);
}

std::optional<CellEstimate> COverlappingHilbertMap::estimateCell(const CellIndex& cell) const
{
  return whole()->cell(cell, insertionOptions.thresholds);
}

void COverlappingHilbertMap::visitCells(const CellVisitor& visitor) const
{
  whole()->visitCells(insertionOptions.thresholds, visitor);
}

std::optional<std::pair<CellIndex, CellIndex>> COverlappingHilbertMap::cellBounds() const
{
  return whole()->cellBounds();
}

int COverlappingHilbertMap::emptyAround(const CellIndex& cell) const
{
  return whole()->emptyAround(cell);
}

RayWalk COverlappingHilbertMap::follow(const RayStretch& ray) const
{
  const auto map = whole();
  return detail::followIn(*map, ray, insertionOptions.thresholds);
}

void COverlappingHilbertMap::withProbs(const UseProbs& use) const
{
  const auto map = whole();
  detail::ProbsIn<OverlappingHilbertMap> probs(*map);
  use(probs);
}

std::vector<CLearnedMap::Fact> COverlappingHilbertMap::facts() const
{
  std::vector<Fact> own{{"blocks", core().evidence().blockCount()}, {"models", core().modelCount()}};
  if (!core().pending().scans.empty())
    own.push_back({"scans that wait for others", core().pending().scans.size()});
  return factsWith(cellFacts(), own);
}

void COverlappingHilbertMap::updateVoxel(double x, double y, double z, bool occupied)
{
  const double weight = occupied ? insertionOptions.hitWeight : -insertionOptions.freeWeight;
  map().addEvidence(addressableCell("updateVoxel", x, y, z), insertionOptions.fieldWeight * weight,
                    insertionOptions.thresholds);
  contentChanged();
}

}  // namespace lamap
