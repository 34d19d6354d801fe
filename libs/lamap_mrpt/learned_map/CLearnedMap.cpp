#include <lamap_mrpt/learned_map/CLearnedMap.h>

#include <lamap_core/options/nearest_name.h>
#include <lamap_mrpt/files/atomic_file.h>
#include <lamap_mrpt/files/map_file.h>
#include <lamap_mrpt/learned_map/cell_walk.h>
#include <lamap_mrpt/learned_map/end_point_likelihood.h>
#include <lamap_mrpt/learned_map/occupied_cells.h>
#include <lamap_mrpt/observations/observation_rays.h>
#include <lamap_mrpt/observations/pose_covariance.h>
#include <mrpt/opengl/COpenGLScene.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <new>
#include <stdexcept>
#include <utility>

namespace lamap
{
namespace
{
bool same(const RangeOptions& a, const RangeOptions& b)
{
  return a.minRange == b.minRange && a.maxRange == b.maxRange &&
         a.considerInvalidRangesAsFreeSpace == b.considerInvalidRangesAsFreeSpace &&
         a.rayDecimation == b.rayDecimation;
}

/// The part of a ray, in units of its direction, inside a box [m]; first > last if there is none.
std::pair<double, double> stretchInBox(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                                       const Eigen::Vector3d& low, const Eigen::Vector3d& high)
{
  double first = 0;
  double last = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 3; ++axis)
  {
    if (direction[axis] == 0)
    {
      if (origin[axis] < low[axis] || origin[axis] > high[axis]) return {1, 0};
      continue;
    }
    const double a = (low[axis] - origin[axis]) / direction[axis];
    const double b = (high[axis] - origin[axis]) / direction[axis];
    first = std::max(first, std::min(a, b));
    last = std::min(last, std::max(a, b));
  }
  return {first, last};
}

/** Writes the centres of the occupied cells as a PLY file of doubles: MRPT's writer knows floats only, which
 * do not tell cells apart in UTM coordinates.
 * @param path   for messages
 * @param place  where to write it. @throws std::runtime_error naming the path */
void writeCentres(const CLearnedMap& map, const std::string& path, const std::string& place)
{
  const std::vector<CellIndex> cells = sortedOccupiedCells(map);
  std::ofstream out(place, std::ios::binary | std::ios::trunc);
  out << "ply\nformat binary_little_endian 1.0\nelement vertex " << cells.size()
      << "\nproperty double x\nproperty double y\nproperty double z\nend_header\n";
  for (const CellIndex& cell : cells)
  {
    const Eigen::Vector3d centre = cellCentre(cell, map.resolution());
    out.write(reinterpret_cast<const char*>(centre.data()), sizeof(double) * 3);
  }
  out.close();
  if (!out) throw std::runtime_error("cannot write " + path);
}
}  // namespace

const OptionTable& CLearnedMap::TLikelihoodOptions::optionTable() const
{
  using Self = TLikelihoodOptions;
  static const OptionTable table =
      OptionTableOf<Self>("likelihoodOpts")
          .add("decimation", &Self::decimation, plain().from(1).to(1e9),
               "use every Nth ray of an observation")
          .add("outlierProb", &Self::outlierProb, plain().from(1e-6).to(1),
               "share of returns without information; half of it is the minimum likelihood of a return")
          .add("endPointStd", &Self::endPointStd, metres().from(0).to(1e3),
               "standard deviation of where a return ends; 0: only the cell it ends in counts")
          .add("freeBefore", &Self::freeBefore, metres().from(0).to(1e3),
               "rays must pass through free space this far before they end, at least two cells; 0: only ends "
               "count")
          .add("unobservedProb", &Self::unobservedProb, plain().from(0).to(1),
               "P(occupied) assumed where the map has no evidence")
          .add("independence", &Self::independence, plain().above(0).to(1),
               "factor of the log-likelihood, below 1 because neighbouring rays have correlated errors");
  return table;
}

const OptionTable& CLearnedMap::TRenderingOptions::optionTable() const
{
  using Self = TRenderingOptions;
  static const OptionTable table =
      OptionTableOf<Self>("renderOpts")
          .add("generateOccupiedVoxels", &Self::generateOccupiedVoxels, plain(),
               "make cubes of occupied cells")
          .add("visibleOccupiedVoxels", &Self::visibleOccupiedVoxels, plain(), "show cubes of occupied cells")
          .add("generateFreeVoxels", &Self::generateFreeVoxels, plain(), "make cubes of free cells")
          .add("visibleFreeVoxels", &Self::visibleFreeVoxels, plain(), "show cubes of free cells")
          .add("generateGridLines", &Self::generateGridLines, plain(), "draw a box around the observed cells")
          .add("hideBuriedVoxels", &Self::hideBuriedVoxels, plain(),
               "omit occupied cells with occupied neighbours on all six sides")
          .add("colourBy", &Self::colourBy, oneOf({"height", "probability", "variance"}),
               "quantity that colours cubes, from blue (low) to red (high)")
          .add("freeOpacity", &Self::freeOpacity, plain().from(0).to(1), "opacity of cubes of free cells");
  return table;
}

// Not the copy constructor of CMetricMap, which would copy its observers.
// NOLINTNEXTLINE(bugprone-copy-constructor-init)
CLearnedMap::CLearnedMap(const CLearnedMap& other)
    : mrpt::maps::CMetricMap(),
      NearestCells(),
      mrpt::system::COutputLogger(other),
      likelihoodOptions(other.likelihoodOptions),
      renderingOptions(other.renderingOptions),
      threadCount_(other.threadCount_),
      tallied_(other.tallied_),
      scansUsed_(other.scansUsed_),
      scansFailed_(other.scansFailed_)
{
  genericMapParams = other.genericMapParams;
}

CLearnedMap& CLearnedMap::operator=(const CLearnedMap& other)
{
  if (this == &other) return *this;
  mrpt::system::COutputLogger::operator=(other);
  genericMapParams = other.genericMapParams;
  likelihoodOptions = other.likelihoodOptions;
  renderingOptions = other.renderingOptions;
  threadCount_ = other.threadCount_;
  tallied_ = other.tallied_;
  scansUsed_ = other.scansUsed_;
  scansFailed_ = other.scansFailed_;
  contentChanged();
  return *this;
}

std::optional<CellEstimate> CLearnedMap::estimateCell(const CellIndex& cell) const
{
  const Eigen::Vector3d centre = cellCentre(cell, resolution());
  return estimateAt({centre.x(), centre.y(), centre.z()});
}

std::string CLearnedMap::Fact::text() const
{
  if (const auto* count = std::get_if<uint64_t>(&number)) return std::to_string(*count);
  return roundedText(std::get<double>(number));
}

std::vector<OptionValue> CLearnedMap::optionValues() const
{
  std::vector<OptionValue> values;
  visitOptionGroups(
      [&](const TOptionGroup& now, const TOptionGroup&)
      {
        for (const Option& option : now.optionTable().options())
        {
          const std::string text = option.textOf(now);
          values.push_back({now.optionTable().name(), option.key, option.get(now),
                            text.empty() ? option.emptyText : text, option.unit});
        }
      });
  return values;
}

bool CLearnedMap::optionIs(const std::string& section, const std::string& key, const std::string& text) const
{
  std::vector<std::string> sections;
  std::optional<bool> isSame;
  visitOptionGroups(
      [&](const TOptionGroup& now, TOptionGroup& untouched)
      {
        const OptionTable& table = now.optionTable();
        sections.push_back(table.name());
        if (table.name() != section) return;
        const Option& option = table.require(key);
        try
        {
          option.parse(untouched, text);
        }
        catch (const std::invalid_argument& error)
        {
          throw std::invalid_argument(section + "." + option.key + " = \"" + text + "\" " + error.what());
        }
        isSame = option.textOf(now) == option.textOf(untouched);
      });
  if (!isSame)
    throw std::invalid_argument("unknown section \"" + section + "\"; " +
                                suggestionFor(section, sections, "\"", "\""));
  return *isSame;
}

bool CLearnedMap::getPointOccupancy(float x, float y, float z, double& prob) const
{
  const auto estimate = estimateAt({x, y, z});
  if (estimate) prob = estimate->prob;
  return estimate.has_value();
}

bool CLearnedMap::castRay(const mrpt::math::TPoint3D& origin, const mrpt::math::TPoint3D& direction,
                          mrpt::math::TPoint3D& end, bool ignoreUnknownCells, double maxRange) const
{
  Eigen::Vector3d start(origin.x, origin.y, origin.z);
  Eigen::Vector3d unit(direction.x, direction.y, direction.z);
  if (!start.allFinite() || !unit.allFinite() || !(unit.norm() > 0)) return false;
  const auto layer = planarLayer();
  if (layer)
  {
    start.z() = (*layer + 0.5) * resolution();
    unit.z() = 0;
    if (!(unit.norm() > 0))
      unit.x() = maxRange = std::numeric_limits<double>::min();  // only the cell it is in
  }
  unit.normalize();

  RayStretch ray{start, unit, 0, maxRange > 0 ? maxRange : std::numeric_limits<double>::infinity(),
                 ignoreUnknownCells};
  if (ignoreUnknownCells)
  {
    // Limited to the box of observed cells: without it, the ray might never end.
    const auto box = observedBox();
    if (!box->any) return false;
    const Eigen::Vector3d margin = Eigen::Vector3d::Constant(resolution());
    const auto stretch = stretchInBox(start, unit, cellCentre(box->low, resolution()) - margin,
                                      cellCentre(box->high, resolution()) + margin);
    ray.tFirst = stretch.first;
    ray.tLast = std::min(ray.tLast, stretch.second);
  }
  const RayWalk followed = follow(ray);
  if (followed.last)
  {
    const Eigen::Vector3d centre = cellCentre(*followed.last, resolution());
    end = {centre.x(), centre.y(), centre.z()};
  }
  return followed.isMet;
}

void CLearnedMap::withProbs(const UseProbs& use) const
{
  class Probs : public CellProbs
  {
   public:
    explicit Probs(const CLearnedMap& map) : map_(map) {}
    std::optional<double> prob(const CellIndex& cell) override
    {
      const auto estimate = map_.estimateCell(cell);
      return estimate ? std::optional(estimate->prob) : std::nullopt;
    }

   private:
    const CLearnedMap& map_;
  } probs(*this);
  use(probs);
}

RayWalk CLearnedMap::follow(const RayStretch& ray) const
{
  const auto stateOf = [&](const CellIndex& cell) -> std::optional<CellState>
  {
    const auto estimate = estimateCell(cell);
    return estimate ? std::optional(estimate->state) : std::nullopt;
  };
  return followRay(ray, resolution(), stateOf, [&](const CellIndex& cell) { return emptyAround(cell); });
}

void CLearnedMap::insertRay(float end_x, float end_y, float end_z, float sensor_x, float sensor_y,
                            float sensor_z)
{
  Scan scan;
  RayFan& fan = scan.fans.emplace_back();
  fan.centre = {sensor_x, sensor_y, sensor_z};
  fan.addReturn({end_x, end_y, end_z});
  insertScan(scan);
}

void CLearnedMap::insertPointCloud(const mrpt::maps::CPointsMap& points, float sensor_x, float sensor_y,
                                   float sensor_z)
{
  Scan scan;
  RayFan& fan = scan.fans.emplace_back();
  fan.centre = {sensor_x, sensor_y, sensor_z};
  fan.rays.reserve(points.size());
  for (size_t i = 0; i < points.size(); ++i)
  {
    mrpt::math::TPoint3D point;
    points.getPoint(i, point);
    fan.addReturn({point.x, point.y, point.z});
  }
  insertScan(scan);
}

void CLearnedMap::saveMetricMapRepresentationToFile(const std::string& prefix) const
{
  saveMapFile(*this, prefix + ".lamap.gz");

  AtomicFile sceneFile(prefix + ".3Dscene");
  mrpt::opengl::COpenGLScene scene;
  const auto objects = mrpt::opengl::CSetOfObjects::Create();
  getVisualizationInto(*objects);
  scene.insert(objects);
  try
  {
    writeCompressed(scene, sceneFile.temporaryPath());
  }
  catch (const std::exception& error)
  {
    throw std::runtime_error("cannot write " + prefix + ".3Dscene: " + compat::messageOf(error));
  }
  sceneFile.commit();

  AtomicFile plyFile(prefix + ".ply");
  writeCentres(*this, prefix + ".ply", plyFile.temporaryPath());
  plyFile.commit();
}

std::string CLearnedMap::asString() const
{
  std::string text = GetRuntimeClass()->className;
  std::string separator = ": ";
  for (const Fact& fact : facts())
    text += std::exchange(separator, "; ") + fact.name + " " + fact.text() +
            (fact.unit.empty() ? "" : " " + fact.unit);
  return text;
}

mrpt::math::TBoundingBoxf CLearnedMap::boundingBox() const
{
  const auto box = observedBox();
  if (!box->any) return {};
  const Eigen::Vector3d half = Eigen::Vector3d::Constant(0.5 * resolution());
  const Eigen::Vector3f low = (cellCentre(box->low, resolution()) - half).cast<float>();
  const Eigen::Vector3f high = (cellCentre(box->high, resolution()) + half).cast<float>();
  return {{low.x(), low.y(), low.z()}, {high.x(), high.y(), high.z()}};
}

void CLearnedMap::auxParticleFilterCleanUp()
{
  endPoints_.reset();
  likelihood_.reset();
  occupied_.reset();
  box_.reset();
}

void CLearnedMap::contentChanged()
{
  ++contentChanges_;
  occupied_.reset();
  box_.reset();
}

bool CLearnedMap::insertScan(const Scan& scan)
{
  const RayCounts counts = learnScan(scan);
  if (counts.used() > 0) contentChanged();
  return tally(counts);
}

bool CLearnedMap::insertObservationAt(const mrpt::obs::CObservation& observation,
                                      const mrpt::poses::CPose3DPDF& robotPose_map)
{
  mrpt::poses::CPose3DPDFGaussian gaussian;
  gaussian.copyFrom(robotPose_map);
  struct Reset
  {
    ~Reset() { pose.reset(); }
    std::optional<mrpt::poses::CPose3DPDFGaussian>& pose;
  } const atTheEnd{uncertainPose_};
  uncertainPose_ = gaussian;
  return insertObservation(observation, gaussian.mean);
}

bool CLearnedMap::learnObservation(const mrpt::obs::CObservation& observation,
                                   const mrpt::poses::CPose3D& robotPose_map,
                                   const mrpt::poses::CPose3DPDF* uncertainPose_map)
{
  if (!supportsObservation(observation)) return false;
  std::optional<Scan> scan = raysOf(observation, robotPose_map);
  if (!scan) return false;
  if (uncertainPose_map != nullptr && scan->sensorPose_map.matrix().allFinite())
  {
    mrpt::poses::CPose3DPDFGaussian gaussian;
    gaussian.copyFrom(*uncertainPose_map);
    scan->poseCovariance = covarianceOfSensor(gaussian, scan->sensorPose_map.translation());
  }
  return insertScan(*scan);
}

bool CLearnedMap::tally(const RayCounts& counts)
{
  const RayCounts before = tallied_;
  tallied_ += counts;
  if (counts.used() > 0) ++scansUsed_;
  try
  {
    const auto tellOnce = [&](size_t soFar, size_t now, const std::string& kind)
    {
      if (soFar == 0 && now > 0)
        MRPT_LOG_WARN_STREAM("rays of a scan that are ignored: " << now << "; " << kind
                                                                 << " (reported once; all are counted)");
    };
    tellOnce(before.notFinite, counts.notFinite, "they are NaN or infinite");
    tellOnce(before.tooLong, counts.tooLong,
             "they are longer than " + shortText(kLongestRay_cells) + " cells of " +
                 roundedText(resolution()) + " m, up to " + roundedText(counts.tooLongLongest_m) +
                 " m; set insertOpts.maxRange, or a larger creationOpts.resolution");
    tellOnce(before.outside, counts.outside,
             "they lie beyond what cell indices can address, or too far from the first sensor of their scan");
    if (before.tooNear == 0 && counts.tooNear > 0)
      MRPT_LOG_INFO_STREAM("rays of a scan that are ignored: "
                           << counts.tooNear << "; closer than the minimum range, or on the sensor");
  }
  catch (const std::bad_alloc&)
  {
    // The scan is in the map: that there was no memory to tell of its rays must not look as if it were not.
  }
  return counts.used() > 0;
}

CellIndex CLearnedMap::addressableCell(const char* caller, double x, double y, double z) const
{
  const auto cell = cellAt({x, y, z}, resolution());
  if (!cell)
    throw std::invalid_argument(std::string(caller) + "(" + roundedText(x) + ", " + roundedText(y) + ", " +
                                roundedText(z) + "): not a point that a cell of " +
                                roundedText(resolution()) + " m can hold");
  return *cell;
}

std::vector<CLearnedMap::Fact> CLearnedMap::cellFacts(const CellVisitor& also) const
{
  size_t cells = 0;
  size_t free = 0;
  size_t occupied = 0;
  visitCells(
      [&](const CellIndex& cell, const CellEstimate& estimate)
      {
        ++cells;
        free += estimate.state == CellState::Free;
        occupied += estimate.state == CellState::Occupied;
        if (also) also(cell, estimate);
      });
  return {{"resolution", resolution(), "m"},
          {"cells", cells},
          {"occupied cells", occupied},
          {"free cells", free},
          {"unknown cells", cells - occupied - free}};
}

std::vector<CLearnedMap::Fact> CLearnedMap::scanFacts() const
{
  if (scansUsed_ == 0 && tallied_.used() == 0 && tallied_.leftOut() == 0 && scansFailed_ == 0)
    return {};  // a map that was only loaded
  std::vector<Fact> facts{{"scans inserted in this session", scansUsed_},
                          {"rays with a hit", tallied_.hits},
                          {"rays as free space only", tallied_.freeOnly},
                          {"rays left out", tallied_.leftOut()}};
  const auto addIfAny = [&](const char* name, size_t count)
  {
    if (count > 0) facts.push_back({name, count});
  };
  addIfAny("rays as free space only, without return", tallied_.noReturn);
  addIfAny("rays taken as narrow, too far apart", tallied_.narrowed);
  addIfAny("rays dropped by the sensor", tallied_.dropped);
  addIfAny("rays left out, not finite", tallied_.notFinite);
  addIfAny("rays left out, too near", tallied_.tooNear);
  addIfAny("rays left out, without return", tallied_.unbounded);
  addIfAny("rays left out, too long for the cells", tallied_.tooLong);
  addIfAny("rays left out, out of reach of the indices", tallied_.outside);
  addIfAny("observations that could not be read or learned", scansFailed_);
  return facts;
}

bool CLearnedMap::internal_insertObservation(const mrpt::obs::CObservation& observation,
                                             const std::optional<const mrpt::poses::CPose3D>& robotPose)
{
  requireLegalInsertion();
  try
  {
    return learnObservation(observation, robotPose ? *robotPose : mrpt::poses::CPose3D(),
                            uncertainPose_ ? &*uncertainPose_ : nullptr);
  }
  catch (const std::exception& error)
  {
    // A SLAM program should continue with the next observation; the map is as it was before this one.
    ++scansFailed_;
    MRPT_LOG_ERROR_STREAM("an observation is ignored: " << compat::messageOf(error));
    return false;
  }
}

bool CLearnedMap::internal_canComputeObservationLikelihood(const mrpt::obs::CObservation& observation) const
{
  return supportsObservation(observation);
}

double CLearnedMap::internal_computeObservationLikelihood(const mrpt::obs::CObservation& observation,
                                                          const mrpt::poses::CPose3D& takenFrom) const
{
  if (!supportsObservation(observation)) return 0;
  const auto likelihood =
      likelihood_.get([](const EndPointLikelihood& made) { return made.isCurrent(); },
                      [&]
                      {
                        likelihoodOptions.validate();
                        return std::make_shared<const EndPointLikelihood>(*this, likelihoodOptions);
                      });
  RangeOptions limits = rangeLimits();
  limits.considerInvalidRangesAsFreeSpace = false;
  limits.rayDecimation = likelihoodOptions.decimation;
  const auto fingerprint = fingerprintOf(observation);
  const auto endPoints = endPoints_.get(
      [&](const EndPoints& made) {
        return fingerprint && made.observation && *made.observation == *fingerprint &&
               same(made.limits, limits);
      },
      [&]
      {
        auto made = std::make_shared<EndPoints>();
        try
        {
          *made = endPointsOf(observation, limits);
        }
        catch (const std::exception& error)
        {
          MRPT_LOG_ERROR_STREAM("an observation has no likelihood: " << compat::messageOf(error));
          made->limits = limits;
        }
        made->observation = fingerprint;
        return made;
      });
  return likelihood->logOf(*endPoints, takenFrom);
}

std::shared_ptr<const OccupiedCells> CLearnedMap::occupiedCells() const
{
  return occupied_.get([&](const OccupiedCells& made) { return made.thresholds() == stateThresholds(); },
                       [&] { return std::make_shared<const OccupiedCells>(*this); });
}

std::shared_ptr<const ObservedBox> CLearnedMap::observedBox() const
{
  return box_.get([&] { return std::make_shared<const ObservedBox>(*this); });
}

}  // namespace lamap
