// Matching of learned maps: their occupied cells are a points map, and CPointsMap knows how to match.
#include <lamap_mrpt/CLearnedMap.h>
#include <lamap_mrpt/occupied_cells.h>
#include <mrpt/maps/CMultiMetricMap.h>
#include <mrpt/maps/CSimplePointsMap.h>

#include <limits>
#include <stdexcept>

namespace lamap
{
namespace
{
using mrpt::maps::CMetricMap;
using mrpt::maps::CPointsMap;

/// The points of a map that has points; nullptr otherwise.
const CPointsMap* pointsOf(const CMetricMap* map)
{
  if (const auto* points = dynamic_cast<const CPointsMap*>(map)) return points;
  if (const auto* learned = dynamic_cast<const CLearnedMap*>(map)) return learned->getAsSimplePointsMap();
  const auto* several = dynamic_cast<const mrpt::maps::CMultiMetricMap*>(map);
  if (!several) return nullptr;
  for (const auto& one : several->maps)
    if (const auto* points = dynamic_cast<const CPointsMap*>(one.get())) return points;
  for (const auto& one : several->maps)
    if (const auto* learned = dynamic_cast<const CLearnedMap*>(one.get()))
      return learned->getAsSimplePointsMap();
  return nullptr;
}

const CPointsMap& requirePoints(const CMetricMap* map)
{
  if (const CPointsMap* points = pointsOf(map)) return *points;
  const std::string name = map ? map->GetRuntimeClass()->className : "nothing";
  throw std::invalid_argument("cannot match with a " + name +
                              ": a points map, a learned map or a CMultiMetricMap that has one is needed");
}
}  // namespace

void CLearnedMap::determineMatching2D(const CMetricMap* otherMap, const mrpt::poses::CPose2D& otherMapPose,
                                      mrpt::tfest::TMatchingPairList& correspondences,
                                      const mrpt::maps::TMatchingParams& params,
                                      mrpt::maps::TMatchingExtraResults& extraResults) const
{
  occupiedCells()->forPlane()->determineMatching2D(&requirePoints(otherMap), otherMapPose, correspondences,
                                                   params, extraResults);
}

void CLearnedMap::determineMatching3D(const CMetricMap* otherMap, const mrpt::poses::CPose3D& otherMapPose,
                                      mrpt::tfest::TMatchingPairList& correspondences,
                                      const mrpt::maps::TMatchingParams& params,
                                      mrpt::maps::TMatchingExtraResults& extraResults) const
{
  occupiedCells()->forSpace()->determineMatching3D(&requirePoints(otherMap), otherMapPose, correspondences,
                                                   params, extraResults);
}

float CLearnedMap::compute3DMatchingRatio(const CMetricMap* otherMap,
                                          const mrpt::poses::CPose3D& otherMapPose,
                                          const mrpt::maps::TMatchingRatioParams& params) const
{
  const CPointsMap* others = pointsOf(otherMap);
  if (!others) return 0;
  mrpt::maps::TMatchingParams matching;
  matching.maxDistForCorrespondence = params.maxDistForCorr;
  mrpt::tfest::TMatchingPairList correspondences;
  mrpt::maps::TMatchingExtraResults results;
  occupiedCells()->forSpace()->determineMatching3D(others, otherMapPose, correspondences, matching, results);
  return results.correspondencesRatio;
}

float CLearnedMap::squareDistanceToClosestCorrespondence(float x0, float y0) const
{
  const auto points = occupiedCells()->forPlane();
  return points->empty() ? std::numeric_limits<float>::max() : points->kdTreeClosestPoint2DsqrError(x0, y0);
}

const mrpt::maps::CSimplePointsMap* CLearnedMap::getAsSimplePointsMap() const
{
  return &occupiedCells()->points();
}

}  // namespace lamap
