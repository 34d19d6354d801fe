// Matching of learned maps, by the centres of their occupied cells.
#include <lamap_mrpt/learned_map/CLearnedMap.h>
#include <lamap_mrpt/learned_map/occupied_cells.h>
#include <mrpt/maps/CMultiMetricMap.h>
#include <mrpt/maps/CSimplePointsMap.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace lamap
{
namespace
{
using mrpt::maps::CMetricMap;
using mrpt::maps::CPointsMap;
using mrpt::maps::CSimplePointsMap;

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
  throw std::invalid_argument(
      "cannot match with a " + name +
      ": it needs a points map, a learned map or a CMultiMetricMap with one of these");
}

/// The nearest of our points and, on request, all others within a distance.
class Neighbours
{
 public:
  Neighbours(const CSimplePointsMap& points, bool flat) : points_(points), flat_(flat) {}

  /// Fills indices and squared distances [m²], nearest first.
  void find(const mrpt::math::TPoint3D& point, double limit_m, bool onlyNearest)
  {
    size_t count = std::min<size_t>(onlyNearest ? 1 : 8, points_.size());
    search(point, count);
    while (!onlyNearest && count < points_.size() && squaredDistances.back() < limit_m * limit_m)
      search(point, count = std::min(2 * count, points_.size()));
    while (!indices.empty() && !(squaredDistances.back() < limit_m * limit_m))
    {
      indices.pop_back();
      squaredDistances.pop_back();
    }
  }

  std::vector<size_t> indices;
  std::vector<float> squaredDistances;

 private:
  void search(const mrpt::math::TPoint3D& point, size_t count)
  {
    const auto x = static_cast<float>(point.x);
    const auto y = static_cast<float>(point.y);
    const auto z = static_cast<float>(point.z);
    if (flat_)
      points_.kdTreeNClosestPoint2DIdx(x, y, count, indices, squaredDistances);
    else
      points_.kdTreeNClosestPoint3DIdx(x, y, z, count, indices, squaredDistances);
  }

  const CSimplePointsMap& points_;
  bool flat_;
};

/** The contract of CPointsMap's methods of these names. Theirs find nothing if the bounding boxes of the two
 * sets of points do not overlap, however close they are, e.g. a wall of cells and a scan of it 1 mm in front.
 */
void matchPoints(const CSimplePointsMap& mine, const CPointsMap& others,
                 const mrpt::poses::CPose3D& otherPose, bool flat, const mrpt::maps::TMatchingParams& params,
                 mrpt::tfest::TMatchingPairList& correspondences, mrpt::maps::TMatchingExtraResults& results)
{
  ASSERT_GT_(params.decimation_other_map_points, size_t{0});
  ASSERT_LT_(params.offset_other_map_points, params.decimation_other_map_points);
  ASSERTMSG_(params.onlyKeepTheClosest || !params.onlyUniqueRobust,
             "onlyUniqueRobust requires onlyKeepTheClosest");
  correspondences.clear();
  results = {};
  if (mine.empty() || others.empty()) return;

  mrpt::tfest::TMatchingPairList pairs;
  Neighbours near(mine, flat);
  size_t matched = 0;
  double sumOfSquares = 0;
  for (size_t i = params.offset_other_map_points; i < others.size(); i += params.decimation_other_map_points)
  {
    mrpt::math::TPoint3D local;
    others.getPoint(i, local);
    const mrpt::math::TPoint3D seen = otherPose.composePoint(local);
    if (!std::isfinite(seen.x) || !std::isfinite(seen.y) || !std::isfinite(seen.z)) continue;
    mrpt::math::TPoint3D fromPivot = seen - params.angularDistPivotPoint;
    if (flat) fromPivot.z = 0;
    near.find(seen,
              params.maxDistForCorrespondence + params.maxAngularDistForCorrespondence * fromPivot.norm(),
              params.onlyKeepTheClosest);
    matched += !near.indices.empty();
    for (size_t k = 0; k < near.indices.size(); ++k)
    {
      mrpt::math::TPoint3D global;
      mine.getPoint(near.indices[k], global);
      pairs.emplace_back(static_cast<uint32_t>(near.indices[k]), static_cast<uint32_t>(i),
                         mrpt::math::TPoint3Df(global), mrpt::math::TPoint3Df(local));
      pairs.back().errorSquareAfterTransformation = near.squaredDistances[k];
      sumOfSquares += near.squaredDistances[k];
    }
  }
  if (!pairs.empty())
    results.sumSqrDist =
        static_cast<float>(sumOfSquares / static_cast<double>(pairs.size()));  // as CPointsMap
  results.correspondencesRatio =
      static_cast<float>(params.decimation_other_map_points * matched) / static_cast<float>(others.size());
  if (params.onlyUniqueRobust)
    pairs.filterUniqueRobustPairs(mine.size(), correspondences);
  else
    correspondences = std::move(pairs);
}
}  // namespace

std::shared_ptr<const CSimplePointsMap> CLearnedMap::cellsToSearch(bool plane) const
{
  return occupiedCells()->searchable(plane);
}

void CLearnedMap::determineMatching2D(const CMetricMap* otherMap, const mrpt::poses::CPose2D& otherMapPose,
                                      mrpt::tfest::TMatchingPairList& correspondences,
                                      const mrpt::maps::TMatchingParams& params,
                                      mrpt::maps::TMatchingExtraResults& extraResults) const
{
  matchPoints(*cellsToSearch(true), requirePoints(otherMap), mrpt::poses::CPose3D(otherMapPose), true, params,
              correspondences, extraResults);
}

void CLearnedMap::determineMatching3D(const CMetricMap* otherMap, const mrpt::poses::CPose3D& otherMapPose,
                                      mrpt::tfest::TMatchingPairList& correspondences,
                                      const mrpt::maps::TMatchingParams& params,
                                      mrpt::maps::TMatchingExtraResults& extraResults) const
{
  matchPoints(*cellsToSearch(false), requirePoints(otherMap), otherMapPose, false, params, correspondences,
              extraResults);
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
  matchPoints(*cellsToSearch(false), *others, otherMapPose, false, matching, correspondences, results);
  return results.correspondencesRatio;
}

float CLearnedMap::squareDistanceToClosestCorrespondence(float x0, float y0) const
{
  const auto points = cellsToSearch(true);
  return points->empty() ? std::numeric_limits<float>::max() : points->kdTreeClosestPoint2DsqrError(x0, y0);
}

const mrpt::maps::CSimplePointsMap* CLearnedMap::getAsSimplePointsMap() const
{
  return &occupiedCells()->points();
}

}  // namespace lamap
