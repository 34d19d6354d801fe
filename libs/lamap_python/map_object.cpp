#include <lamap_core/math/workers.h>
#include <lamap_mrpt/files/map_file.h>
#include <lamap_mrpt/maps/CBGKMap.h>
#include <lamap_mrpt/maps/CGPMap.h>
#include <lamap_mrpt/maps/CHilbertMap.h>
#include <lamap_mrpt/maps/COverlappingHilbertMap.h>
#include <lamap_mrpt/observations/isometry.h>
#include <lamap_mrpt/observations/pose_covariance.h>
#include <lamap_python/arrays.h>
#include <lamap_python/errors.h>
#include <lamap_python/map_object.h>
#include <lamap_python/options.h>
#include <lamap_python/paths.h>
#include <lamap_tools/cells/cell_table.h>
#include <mrpt/io/CMemoryStream.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/serialization/CArchive.h>

#include <algorithm>
#include <cstdio>
#include <limits>
#include <stdexcept>
#include <vector>

namespace py = pybind11;
using namespace pybind11::literals;

namespace lamap::python
{
namespace
{
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr int8_t kUnobserved = -1;  ///< beside the numbers of CellState

/// An object of a class that the module has.
template <typename... Arguments>
py::object make(const char* name, Arguments&&... arguments)
{
  return py::module_::import("lamap").attr(name)(std::forward<Arguments>(arguments)...);
}

/// Numbers as an array that owns them, without a copy.
template <typename Number>
py::array arrayOf(std::vector<Number>&& numbers, const std::vector<py::ssize_t>& shape)
{
  auto owned = std::make_unique<std::vector<Number>>(std::move(numbers));
  Number* const first = owned->data();
  const py::capsule owner(owned.release(), [](void* all) { delete static_cast<std::vector<Number>*>(all); });
  return py::array_t<Number>(shape, first, owner);
}

template <typename Number>
py::array arrayOf(std::vector<Number>&& numbers)
{
  const auto size = static_cast<py::ssize_t>(numbers.size());
  return arrayOf(std::move(numbers), {size});
}

/// Calls visit(i) for each i below count, by as many threads as the map may use.
template <typename Visit>
void forEach(const CLearnedMap& map, size_t count, const Visit& visit)
{
  constexpr size_t kTogether = 4096;  // queries are short
  Workers(count > kTogether ? map.threadCount() : 1)
      .forEach((count + kTogether - 1) / kTogether,
               [&](size_t part)
               {
                 const size_t end = std::min(count, (part + 1) * kTogether);
                 for (size_t i = part * kTogether; i < end; ++i) visit(i);
               });
}

std::vector<uint8_t> bytesOf(const CLearnedMap& map)
{
  mrpt::io::CMemoryStream stream;
  auto archive = mrpt::serialization::archiveFrom(stream);
  archive << map;
  const auto* first = static_cast<const uint8_t*>(stream.getRawBufferData());
  return {first, first + stream.getTotalBytesCount()};
}

std::shared_ptr<CLearnedMap> mapOf(const std::string& bytes)
{
  mrpt::io::CMemoryStream stream;
  stream.assignMemoryNotOwn(bytes.data(), bytes.size());
  auto archive = mrpt::serialization::archiveFrom(stream);
  mrpt::serialization::CSerializable::Ptr object;
  try
  {
    archive >> object;
  }
  catch (const std::exception& error)
  {
    throw std::invalid_argument("the pickled map cannot be read: " + compat::messageOf(error));
  }
  auto map = std::dynamic_pointer_cast<CLearnedMap>(object);
  if (!map) throw std::invalid_argument("the pickled object is none of this library's maps");
  return map;
}

std::string pythonNameOf(const CLearnedMap& map)
{
  const std::string name = map.GetRuntimeClass()->className;  // "lamap::CBGKMap"
  return name.substr(name.rfind(':') + 2);
}

// ---- Insertion

void requireOneFrame(const py::object& origin, const py::object& pose)
{
  if (!origin.is_none() && !pose.is_none())
    throw std::invalid_argument(
        "origin and pose: give one of them, for points in the frame of the map or of the sensor");
}

void setBeam(RayFan& fan, double beamWidth, double beamHeight, double rangeStd)
{
  fan.beam.halfWidth_rad = beamWidth / 2;
  fan.beam.halfHeight_rad = beamHeight / 2;
  fan.beam.rangeStd_m = rangeStd;
  if (!isLegalBeam(fan.beam))
    throw std::invalid_argument("beam_width, beam_height, range_std: must be finite and not negative");
}

bool insert(MapObject& map, const py::object& points, const py::object& origin, const py::object& pose,
            const py::object& covariance, const py::object& returned, double minRange, double maxRange,
            double beamWidth, double beamHeight, double rangeStd)
{
  requireOneFrame(origin, pose);
  const Vectors ends(points, "points");
  Scan scan;
  RayFan& fan = scan.fans.emplace_back();
  if (!pose.is_none()) scan.sensorPose_map = onePoseOf(pose, "pose");
  if (!origin.is_none()) fan.centre = vectorOf(origin, "origin");
  if (!covariance.is_none())
  {
    // Of the pose that was given, or of one at the origin of the rays, along the axes of the map.
    mrpt::poses::CPose3DPDFGaussian uncertain;
    uncertain.mean = origin.is_none()
                         ? lamap::poseOf(Eigen::Isometry3d(scan.sensorPose_map.matrix()))
                         : mrpt::poses::CPose3D(fan.centre.x(), fan.centre.y(), fan.centre.z(), 0, 0, 0);
    uncertain.cov = mrpt::math::CMatrixDouble66(covarianceOf(covariance));
    scan.poseCovariance = covarianceOfSensor(uncertain, scan.sensorPose_map.translation());
  }
  if (!(minRange >= 0) || !(maxRange >= 0))
    throw std::invalid_argument("min_range, max_range: must be >= 0, in m");
  fan.statedRangeMin_m = minRange;
  fan.statedRangeMax_m = maxRange;
  setBeam(fan, beamWidth, beamHeight, rangeStd);
  const std::vector<bool> isReturn =
      returned.is_none() ? std::vector<bool>() : maskOf(returned, "returned", ends.size());
  return map.change(
      [&](CLearnedMap& changed)
      {
        fan.rays.reserve(ends.size());
        for (size_t i = 0; i < ends.size(); ++i)
          if (isReturn.empty() || isReturn[i])
            fan.addReturn(ends[i]);
          else
            fan.add(RayEnd::NoReturn, ends[i] - fan.centre);
        return changed.insertScan(scan);
      });
}

// ---- Reading

py::object query(const MapObject& map, const py::object& points)
{
  const Vectors places(points, "points", true);
  const size_t size = places.size();
  std::vector<double> prob(size);
  std::vector<double> variance(size);
  std::vector<int8_t> state(size);
  map.read(
      [&](const CLearnedMap& asked)
      {
        forEach(asked, size,
                [&](size_t i)
                {
                  const Eigen::Vector3d place = places[i];
                  const auto estimate = asked.estimateAt({place.x(), place.y(), place.z()});
                  prob[i] = estimate ? estimate->prob : kNaN;
                  variance[i] = estimate && estimate->variance ? *estimate->variance : kNaN;
                  state[i] = estimate ? static_cast<int8_t>(estimate->state) : kUnobserved;
                });
        return true;
      });
  std::vector<py::ssize_t> shape;
  if (!places.isOne()) shape.push_back(static_cast<py::ssize_t>(size));
  return make("Estimates", arrayOf(std::move(prob), shape), arrayOf(std::move(variance), shape),
              arrayOf(std::move(state), shape));
}

py::object cells(const MapObject& map)
{
  std::vector<double> centre;
  std::vector<double> prob;
  std::vector<double> variance;
  std::vector<int8_t> state;
  std::vector<double> evidence;
  const auto [names, edge_m] = map.read(
      [&](const CLearnedMap& read)
      {
        const std::vector<std::string> evidenceNames = read.evidenceNames();
        const double resolution_m = read.resolution();
        const auto add = [&](const tools::CellRow& row)
        {
          const Eigen::Vector3d place = cellCentre(row.index, resolution_m);
          centre.insert(centre.end(), {place.x(), place.y(), place.z()});
          prob.push_back(row.estimate.prob);
          variance.push_back(row.estimate.variance.value_or(kNaN));
          state.push_back(static_cast<int8_t>(row.estimate.state));
          for (size_t i = 0; i < evidenceNames.size(); ++i) evidence.push_back(row.estimate.evidence[i]);
        };
        tools::visitCellsSorted(*tools::cellsOf(map.pointer()), add);
        return std::make_pair(evidenceNames, resolution_m);
      });
  const auto size = static_cast<py::ssize_t>(prob.size());
  const auto columns = static_cast<py::ssize_t>(names.size());
  return make("Cells", arrayOf(std::move(centre), {size, 3}), edge_m, arrayOf(std::move(prob)),
              arrayOf(std::move(variance)), arrayOf(std::move(state)),
              arrayOf(std::move(evidence), {size, columns}));
}

/// How many rays so many origins and directions make.
size_t rayCount(const Vectors& origins, const Vectors& directions)
{
  if (!origins.isOne() && !directions.isOne() && origins.size() != directions.size())
    throw std::invalid_argument("directions: must be as many as origins, " + std::to_string(origins.size()) +
                                ", not " + std::to_string(directions.size()));
  return origins.isOne() ? directions.size() : origins.size();
}

py::object castRays(const MapObject& map, const py::object& origins, const py::object& directions,
                    const py::object& maxRange, bool ignoreUnknown)
{
  const Vectors from(origins, "origins", true);
  const Vectors along(directions, "directions", true);
  const double limit_m = maxRange.is_none() ? -1 : maxRange.cast<double>();
  if (!maxRange.is_none() && !(limit_m > 0))
    throw std::invalid_argument("max_range: must be > 0, in m, or None");
  const size_t size = rayCount(from, along);
  // Not std::vector<bool>: threads write side by side.
  std::vector<uint8_t> hit(size);
  std::vector<double> end(3 * size);
  map.read(
      [&](const CLearnedMap& read)
      {
        forEach(read, size,
                [&](size_t i)
                {
                  const Eigen::Vector3d origin = from[i];
                  const Eigen::Vector3d direction = along[i];
                  mrpt::math::TPoint3D last(kNaN, kNaN, kNaN);
                  hit[i] = static_cast<uint8_t>(read.castRay({origin.x(), origin.y(), origin.z()},
                                                             {direction.x(), direction.y(), direction.z()},
                                                             last, ignoreUnknown, limit_m));
                  end[3 * i] = last.x;
                  end[3 * i + 1] = last.y;
                  end[3 * i + 2] = last.z;
                });
        return true;
      });
  std::vector<py::ssize_t> shape;
  if (!from.isOne() || !along.isOne()) shape.push_back(static_cast<py::ssize_t>(size));
  std::vector<py::ssize_t> shapeOfEnds = shape;
  shapeOfEnds.push_back(3);
  return make("Rays", arrayOf(std::move(hit), shape).attr("view")("bool"),
              arrayOf(std::move(end), shapeOfEnds));
}

py::array logLikelihood(const MapObject& map, const py::object& points, const py::object& poses)
{
  const Vectors ends(points, "points");
  const Poses places(poses, "poses");
  mrpt::obs::CObservationPointCloud cloud;
  auto inCloud = mrpt::maps::CSimplePointsMap::Create();
  cloud.pointcloud = inCloud;
  std::vector<double> logs(places.poses.size());
  map.read(
      [&](const CLearnedMap& asked)
      {
        inCloud->reserve(ends.size());
        for (size_t i = 0; i < ends.size(); ++i)
        {
          const Eigen::Vector3f end = ends[i].cast<float>();
          inCloud->insertPointFast(end.x(), end.y(), end.z());
        }
        for (size_t i = 0; i < logs.size(); ++i)
          logs[i] = asked.computeObservationLikelihood(
              cloud, lamap::poseOf(Eigen::Isometry3d(places.poses[i].matrix())));
        return true;
      });
  std::vector<py::ssize_t> shape;
  if (!places.isOne) shape.push_back(static_cast<py::ssize_t>(logs.size()));
  return arrayOf(std::move(logs), shape);
}

py::object bounds(const MapObject& map)
{
  const auto box =
      map.read([](const CLearnedMap& read) { return std::pair(read.cellBounds(), read.resolution()); });
  if (!box.first) return py::none();
  const double r = box.second;
  const auto& [low, high] = *box.first;
  return arrayOf(std::vector<double>{low.x * r, low.y * r, low.z * r, (high.x + 1.0) * r, (high.y + 1.0) * r,
                                     (high.z + 1.0) * r},
                 {2, 3});
}

py::dict rayCounts(const MapObject& map)
{
  const RayCounts counts = map.read([](const CLearnedMap& read) { return read.rayCounts(); });
  return py::dict("hits"_a = counts.hits, "free_only"_a = counts.freeOnly, "no_return"_a = counts.noReturn,
                  "narrowed"_a = counts.narrowed, "decimated"_a = counts.decimated,
                  "dropped"_a = counts.dropped, "not_finite"_a = counts.notFinite,
                  "too_near"_a = counts.tooNear, "unbounded"_a = counts.unbounded,
                  "too_long"_a = counts.tooLong, "outside"_a = counts.outside);
}

std::string repr(const MapObject& map)
{
  return map.read(
      [](const CLearnedMap& read)
      {
        const double r = read.resolution();
        std::string text = "<lamap." + pythonNameOf(read) + ": cells of " + roundedText(r) + " m, ";
        const auto box = read.cellBounds();
        if (!box) return text + "empty>";
        const auto point = [&](const CellIndex& cell, int32_t end)
        {
          return "(" + fixedText((cell.x + end) * r, 2) + ", " + fixedText((cell.y + end) * r, 2) + ", " +
                 fixedText((cell.z + end) * r, 2) + ")";
        };
        return text + "from " + point(box->first, 0) + " to " + point(box->second, 1) + " m, " +
               fixedText(static_cast<double>(read.memoryBytes()) / (1024 * 1024), 1) + " MiB>";
      });
}

bool areEqual(const MapObject& a, const MapObject& b)
{
  if (&a == &b) return true;
  if (typeid(a) != typeid(b)) return false;
  const std::vector<uint8_t> bytes = a.read(bytesOf);
  return bytes == b.read(bytesOf);
}

// ---- Changing and files

/// Of another class's map that is known to be of the same class. @param merge  a member of Map
template <typename Map>
void mergeInto(MapOf<Map>& map, const MapOf<Map>& other)
{
  // A copy: no thread holds two locks.
  const auto added = std::dynamic_pointer_cast<Map>(other.copy());
  map.change(
      [&](CLearnedMap& changed)
      {
        dynamic_cast<Map&>(changed).merge(*added);
        return true;
      });
}

std::unique_ptr<MapObject> load(const py::handle& path)
{
  const std::string name = pathOf(path);
  auto map = [&]
  {
    const ReleasedGil released;
    return withFile(name, [&] { return loadMapFile(name); });
  }();
  auto learned = std::dynamic_pointer_cast<CLearnedMap>(map);
  if (!learned)
    throw FileError(
        name + ": its map is a " + map->GetRuntimeClass()->className + ", not one of this library's maps",
        name);
  return objectOf(std::move(learned));
}

void save(const MapObject& map, const py::object& path)
{
  const std::string name = pathOf(path);
  map.read(
      [&](const CLearnedMap& saved)
      {
        withFile(name, [&] { saveMapFile(saved, name); });
        return true;
      });
}

py::object report(const MapObject& map)
{
  if (map.report.empty()) return py::none();
  return py::module_::import("json").attr("loads")(map.report);
}

constexpr const char* kInsertDoc =
    R"(insert($self, /, points, *, origin=None, pose=None, covariance=None, returned=None, min_range=0.0, max_range=0.0, beam_width=0.0, beam_height=0.0, range_std=0.0)
--

Learn one scan. All or nothing: if it raises, the map is as it was.

points      (N, 3) [m], where the rays ended. Arrays of float32 and float64, of any strides, are read in
            place. A point that is NaN or infinite is counted and left out.
origin      (3,) [m], where the rays began: the points are in the frame of the map. Default: (0, 0, 0).
pose        of the sensor in the map: the points are in the frame of the sensor. A (4, 4) matrix, or the 6
            numbers x, y, z [m], yaw, pitch, roll [rad] in MRPT's order. Give origin or pose, not both.
covariance  (6, 6), of x, y, z, yaw, pitch, roll [m, rad], in MRPT's order, of that pose, or of a pose at the
            origin along the axes of the map. Counts if the map's usePoseCovariance is true.
returned    (N,) of bool: false where the ray met nothing within max_range; its point is anywhere along it.
min_range   [m], max_range [m]: what the sensor measures; 0: not stated. A ray without a return needs
            max_range here, or maxRange among the options.
beam_width, beam_height   [rad], opening angles of a beam about the sensor's z axis and across that
range_std   [m], standard deviation of a range

Return whether any ray was used; `ray_counts` tells what became of them.)";

constexpr const char* kQueryDoc = R"(query($self, /, points)
--

What the map says at points of its frame.

points  (N, 3) [m], or (3,) for one point; read in place as by insert()

Return Estimates(prob, variance, state), arrays of the shape (N,): P(occupied), NaN where the map has observed
nothing; variance of it, NaN also where the kind of map gives none; State as int8. The map's `threads` are
used.)";

constexpr const char* kCellsDoc = R"(cells($self, /)
--

All cells with evidence, sorted by z, y, x; what is stored once for several cells is expanded.

Return Cells(centre, size, prob, variance, state, evidence): centres (M, 3) [m]; edge of a cell [m], a float;
P(occupied) (M,); its variance (M,), NaN where there is none; State (M,) as int8; and what the map keeps of a
cell (M, K), named by `evidence_names`.)";

constexpr const char* kCastRaysDoc =
    R"(cast_rays($self, /, origins, directions, max_range=None, *, ignore_unknown=False)
--

Follow rays from cell to cell to the first occupied one.

origins, directions   (N, 3) or (3,) for all rays, in the frame of the map [m]; directions of any length > 0
max_range             [m]; None: no limit
ignore_unknown        whether a ray goes on through cells without evidence, which end it otherwise

Return Rays(hit, end): bool (N,), whether an occupied cell was met, and (N, 3) [m], the centre of that cell or of
the last one visited; NaN where none was.)";

constexpr const char* kLogLikelihoodDoc = R"(log_likelihood($self, /, points, poses)
--

How well a scan fits the map at poses of its sensor, for localization: see decimation, outlierProb, endPointStd,
freeBefore, unobservedProb and independence among the options.

points  (N, 3) [m] in the frame of the sensor
poses   one or K poses as insert() takes them: (4, 4), (6,), (K, 4, 4) or (K, 6)

Return the logarithms of the likelihoods (K,), up to a constant.)";

/// What the maps of all kinds have.
void addMap(py::module_& module)
{
  py::class_<MapObject>(module, "LearnedMap",
                        R"(What the maps of all kinds have in common; C++: lamap::CLearnedMap.

Any number of threads may read a map at a time; one that changes it waits for them. The GIL is released
meanwhile. Maps are pickled and copied as a whole, without `threads`, `ray_counts` and `report`. Maps are equal
if they are of one kind and have the same options and evidence.)")
      .def("insert", insert, kInsertDoc, "points"_a, py::kw_only(), "origin"_a = py::none(),
           "pose"_a = py::none(), "covariance"_a = py::none(), "returned"_a = py::none(), "min_range"_a = 0.0,
           "max_range"_a = 0.0, "beam_width"_a = 0.0, "beam_height"_a = 0.0, "range_std"_a = 0.0)
      .def("query", query, kQueryDoc, "points"_a)
      .def("cells", cells, kCellsDoc)
      .def("cast_rays", castRays, kCastRaysDoc, "origins"_a, "directions"_a, "max_range"_a = py::none(),
           py::kw_only(), "ignore_unknown"_a = false)
      .def("log_likelihood", logLikelihood, kLogLikelihoodDoc, "points"_a, "poses"_a)
      .def("save", save,
           "save($self, /, path)\n--\n\nWrite the map to a file, by convention `name.lamap.gz`: completely "
           "or not at "
           "all. The same map gives the same bytes.",
           "path"_a)
      .def(
          "clear",
          [](MapObject& map)
          {
            map.change(
                [](CLearnedMap& changed)
                {
                  changed.clear();
                  return true;
                });
          },
          "clear($self, /)\n--\n\nForget all evidence. The options stay.")
      .def_property_readonly(
          "options",
          [](const MapObject& map)
          { return optionsOf(map.read([](const CLearnedMap& read) { return read.optionValues(); })); },
          "All options by their names in .ini files, read-only; lengths in m. `type(map)(**map.options)` is "
          "an "
          "empty map with the same ones.")
      .def_property_readonly(
          "resolution",
          [](const MapObject& map)
          { return map.read([](const CLearnedMap& read) { return read.resolution(); }); },
          "Edge of a cell [m].")
      .def_property_readonly(
          "bounds", bounds,
          "The two corners of the box of all cells with evidence, (2, 3) [m]; None if empty.")
      .def_property_readonly(
          "is_empty",
          [](const MapObject& map)
          { return map.read([](const CLearnedMap& read) { return read.isEmpty(); }); },
          "Whether the map has no evidence.")
      .def_property_readonly(
          "evidence_names",
          [](const MapObject& map)
          {
            py::list names;
            for (const std::string& name :
                 map.read([](const CLearnedMap& read) { return read.evidenceNames(); }))
              names.append(name);
            return py::tuple(names);
          },
          "Names of the columns of Cells.evidence.")
      .def_property_readonly("ray_counts", rayCounts,
                             "What became of all rays since the map was made or loaded, a dict of counts.")
      .def_property_readonly(
          "report", report,
          "How lamap.build() made the map, a dict as `lamap build --json` prints it; None otherwise.")
      .def_property(
          "threads",
          [](const MapObject& map)
          { return map.read([](const CLearnedMap& read) { return read.threadCount(); }); },
          [](MapObject& map, unsigned threads)
          {
            map.change(
                [&](CLearnedMap& changed)
                {
                  changed.setThreadCount(threads);
                  return true;
                });
          },
          "Number of threads that one call may use; 0, the default: as many as the machine has. Never "
          "changes a "
          "result.")
      .def("__repr__", repr)
      .def("__str__", [](const MapObject& map)
           { return map.read([](const CLearnedMap& read) { return read.asString(); }); })
      .def("__eq__", areEqual, py::is_operator())
      .def("__copy__", [](const MapObject& map) { return objectOf(map.copy()); })
      .def(
          "__deepcopy__", [](const MapObject& map, const py::dict&) { return objectOf(map.copy()); },
          "memo"_a);
}

/// What every class of maps has of its own.
template <typename Map>
py::class_<MapOf<Map>, MapObject> addClass(py::module_& module, const char* alias, const char* doc)
{
  using Object = MapOf<Map>;
  auto added = py::class_<Object, MapObject>(module, std::string(Map::className).substr(8).c_str(), doc);
  added.def(py::init([alias](const py::kwargs& options) { return Object::of(makeMap(alias, options)); }),
            "__init__($self, /, **options)\n--\n\nAn empty map. Every option is a keyword, by its name in "
            ".ini files: see "
            "doc/options.md and `options`.");
  added.attr("alias") = alias;
  added.def_static(
      "load",
      [](const py::object& path)
      {
        auto object = load(path);
        if (dynamic_cast<Object*>(object.get()) == nullptr)
          throw FileError(pathOf(path) + ": its map is a " + object->pointer()->GetRuntimeClass()->className +
                              ", not a " + Map::className,
                          pathOf(path));
        return object;
      },
      "load(path)\n--\n\nRead a map of this class from a file.", "path"_a);
  added.def(py::pickle(
      [](const Object& map)
      {
        const std::vector<uint8_t> bytes = map.read(bytesOf);
        return py::bytes(reinterpret_cast<const char*>(bytes.data()), bytes.size());
      },
      [](const py::bytes& state)
      {
        const std::string bytes = state;
        auto map = mapOf(bytes);
        if (std::dynamic_pointer_cast<Map>(map) == nullptr)
          throw std::invalid_argument("the pickled map is of another class");
        return Object::of(std::move(map));
      }));
  // Protocols 0 and 1 would make the object without its class's __new__.
  added.def("__reduce_ex__",
            [](const py::object& self, int protocol)
            {
              return py::module_::import("builtins")
                  .attr("object")
                  .attr("__reduce_ex__")(self, std::max(protocol, 2));
            });
  return added;
}

constexpr const char* kMergeDoc =
    "merge($self, /, other)\n--\n\nAdd all evidence of another map, as if its scans had been inserted here. "
    "Both need "
    "the same cells.";

void addKinds(py::module_& module)
{
  addClass<CBGKMap>(module, "bgkMap",
                    "Bayesian generalized kernel inference: the fastest; C++: lamap::CBGKMap.")
      .def("merge", mergeInto<CBGKMap>, kMergeDoc, "other"_a);
  addClass<CGPMap>(module, "gpMap", "Gaussian processes in blocks: the baseline; C++: lamap::CGPMap.")
      .def("merge", mergeInto<CGPMap>, kMergeDoc, "other"_a);
  addClass<CHilbertMap>(
      module, "hilbertMap",
      "One logistic regression on spatial features: continuous and accurate; C++: lamap::CHilbertMap. "
      "Cannot be merged.");
  addClass<COverlappingHilbertMap>(module, "overlappingHilbertMap",
                                   "One Hilbert map per scan, fused; C++: lamap::COverlappingHilbertMap.")
      .def("merge", mergeInto<COverlappingHilbertMap>, kMergeDoc, "other"_a)
      .def_property_readonly(
          "model_count",
          [](const MapOf<COverlappingHilbertMap>& map)
          {
            return map.read([](const CLearnedMap& read)
                            { return dynamic_cast<const COverlappingHilbertMap&>(read).modelCount(); });
          },
          "Number of models, one for each scan with the default scansPerModel.")
      .def(
          "model_pose",
          [](const MapOf<COverlappingHilbertMap>& map, size_t model)
          {
            const Eigen::Matrix4d pose = map.read(
                [&](const CLearnedMap& read) {
                  return isometryOf(dynamic_cast<const COverlappingHilbertMap&>(read).modelPose(model))
                      .matrix();
                });
            std::vector<double> rows;
            for (int row = 0; row < 4; ++row)
              for (int column = 0; column < 4; ++column) rows.push_back(pose(row, column));
            return arrayOf(std::move(rows), {4, 4});
          },
          "model_pose($self, /, model)\n--\n\nThe pose of a model's sensor in the map, a (4, 4) matrix.",
          "model"_a)
      .def(
          "set_model_pose",
          [](MapOf<COverlappingHilbertMap>& map, size_t model, const py::object& pose)
          {
            const auto moved = lamap::poseOf(Eigen::Isometry3d(onePoseOf(pose, "pose").matrix()));
            map.change(
                [&](CLearnedMap& changed)
                {
                  dynamic_cast<COverlappingHilbertMap&>(changed).setModelPose(model, moved);
                  return true;
                });
          },
          "set_model_pose($self, /, model, pose)\n--\n\nMove a model to a better pose of its sensor, of a "
          "pose graph for "
          "example. The map is then the one that would have been built with that pose.",
          "model"_a, "pose"_a);
}
}  // namespace

MapObject::MapObject(std::shared_ptr<CLearnedMap> map) : map_(std::move(map))
{
  redirectMessages(*map_);
}

std::shared_ptr<CLearnedMap> MapObject::copy() const
{
  return read([](const CLearnedMap& map)
              { return std::dynamic_pointer_cast<CLearnedMap>(map.duplicateGetSmartPtr()); });
}

std::unique_ptr<MapObject> objectOf(std::shared_ptr<CLearnedMap> map)
{
  if (std::dynamic_pointer_cast<CBGKMap>(map)) return MapOf<CBGKMap>::of(std::move(map));
  if (std::dynamic_pointer_cast<CGPMap>(map)) return MapOf<CGPMap>::of(std::move(map));
  if (std::dynamic_pointer_cast<CHilbertMap>(map)) return MapOf<CHilbertMap>::of(std::move(map));
  return MapOf<COverlappingHilbertMap>::of(std::move(map));
}

void addMaps(py::module_& module)
{
  addMap(module);
  addKinds(module);
  module.def("load", load, "load(path)\n--\n\nRead a map of any of the four classes from a file.", "path"_a);
}

}  // namespace lamap::python
