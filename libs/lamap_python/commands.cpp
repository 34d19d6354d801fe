#include <lamap_mrpt/files/map_file.h>
#include <lamap_mrpt/learned_map/CLearnedMap.h>
#include <lamap_python/arrays.h>
#include <lamap_python/commands.h>
#include <lamap_python/errors.h>
#include <lamap_python/map_object.h>
#include <lamap_python/messages.h>
#include <lamap_python/options.h>
#include <lamap_python/paths.h>
#include <lamap_tools/cells/truth.h>
#include <lamap_tools/commands/map_build.h>
#include <lamap_tools/files/usage_error.h>
#include <lamap_tools/scores/score_report.h>

#include <atomic>
#include <chrono>
#include <exception>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace py = pybind11;
using namespace pybind11::literals;

namespace lamap::python
{
namespace
{
/** What Python wants of a long task: that Ctrl-C stops it, and to see its progress. Asked without the GIL. */
class Listener
{
 public:
  /// @param progress  called with (done, expected, input); None: nobody is told
  explicit Listener(py::object progress) : progress_(std::move(progress)) {}

  bool shouldStop()
  {
    ask([] { return PyErr_CheckSignals() == 0; }, lastSignals_);
    return raised_ != nullptr;
  }
  void show(const tools::Progress& progress)
  {
    if (progress_.is_none()) return;
    const auto tell = [&]
    {
      progress_(progress.done, progress.expected, progress.input);
      return true;
    };
    if (progress.done == progress.expected) lastShown_ = {};
    ask(tell, lastShown_);
  }
  /// What Python raised meanwhile.
  void rethrow() const
  {
    if (raised_) std::rethrow_exception(raised_);
  }

 private:
  using Clock = std::chrono::steady_clock;

  /// Calls work() with the GIL, at most thirty times per second. @param work  false: an exception is set
  template <typename Work>
  void ask(const Work& work, Clock::time_point& last)
  {
    if (raised_ || Clock::now() - last < std::chrono::milliseconds(33)) return;
    last = Clock::now();
    const HeldGil gil;
    try
    {
      if (!work()) throw py::error_already_set();
    }
    catch (...)
    {
      raised_ = std::current_exception();
    }
  }

  py::object progress_;
  std::exception_ptr raised_;
  Clock::time_point lastSignals_;
  Clock::time_point lastShown_;
};

/// Takes arguments by name; those that are left are options of the map.
class Keywords
{
 public:
  explicit Keywords(const py::kwargs& keywords) : left_(keywords.attr("copy")()) {}

  /// @return nothing if it is absent or None
  std::optional<py::object> take(const char* name)
  {
    const py::object taken = left_.attr("pop")(name, py::none());
    if (taken.is_none()) return std::nullopt;
    return taken;
  }
  template <typename Content>
  void take(const char* name, Content& content)
  {
    const auto taken = take(name);
    if (!taken) return;
    try
    {
      content = taken->cast<Content>();
    }
    catch (const py::cast_error&)
    {
      throw py::type_error(std::string(name) + ": is of the wrong type, " +
                           std::string(py::str(py::type::handle_of(*taken).attr("__name__"))));
    }
  }
  [[nodiscard]] const py::dict& left() const { return left_; }

 private:
  py::dict left_;
};

std::vector<std::string> textsOf(const py::object& texts)
{
  if (py::isinstance<py::str>(texts)) return {std::string(py::str(texts))};
  std::vector<std::string> all;
  for (const py::handle text : texts) all.emplace_back(py::str(text));
  return all;
}

/// One of several words. @throws std::invalid_argument naming them
template <typename Choice>
void takeChoice(Keywords& keywords, const char* name,
                const std::vector<std::pair<std::string, Choice>>& words, Choice& choice)
{
  std::string text;
  keywords.take(name, text);
  if (text.empty()) return;
  std::string all;
  for (const auto& [word, meaning] : words)
  {
    if (word == text)
    {
      choice = meaning;
      return;
    }
    all += (all.empty() ? "" : ", ") + word;
  }
  throw std::invalid_argument(std::string(name) + ": '" + text + "' is none of: " + all);
}

/// One number, which then stands for both, or two.
std::optional<std::pair<double, double>> takeOneOrTwo(Keywords& keywords, const char* name)
{
  const auto taken = keywords.take(name);
  if (!taken) return std::nullopt;
  const std::vector<double> numbers = numbersOf(*taken, name);
  if (numbers.empty() || numbers.size() > 2)
    throw std::invalid_argument(std::string(name) + ": must be one number or two");
  return std::pair(numbers.front(), numbers.back());
}

void takeChosenScans(Keywords& keywords, tools::ScanChoice& choice)
{
  if (const auto sensors = keywords.take("sensors")) choice.sensors = textsOf(*sensors);
  keywords.take("every", choice.every);
  if (const auto from = keywords.take("from_time")) choice.from = tools::LogTime("from_time", py::str(*from));
  if (const auto to = keywords.take("to_time")) choice.to = tools::LogTime("to_time", py::str(*to));
}

void takePings(Keywords& keywords, tools::PingRules& pings)
{
  if (const auto beam = takeOneOrTwo(keywords, "ping_beam"))
    std::tie(pings.beamWidth_deg, pings.beamHeight_deg) = *beam;
  takeChoice<tools::AngleUnit>(keywords, "ping_angles",
                               {{"degrees", tools::AngleUnit::Degrees},
                                {"radians", tools::AngleUnit::Radians},
                                {"gradians", tools::AngleUnit::Gradians}},
                               pings.azimuthUnit);
  pings.threshold = takeOneOrTwo(keywords, "ping_threshold");
  keywords.take("ping_dead_zone", pings.deadZone_m);
  keywords.take("ping_separation", pings.separation_m);
  keywords.take("ping_echoes", pings.mostEchoes);
}

tools::BuildOptions takeBuildOptions(const py::object& log, const py::object& map, Keywords& keywords)
{
  tools::BuildOptions build;
  tools::InputOptions& inputs = build.inputs;
  inputs.paths = pathsOf(log);
  if (const auto path = keywords.take("config")) build.map.configPath = pathOf(*path);
  if (const auto path = keywords.take("onto")) build.ontoPath = pathOf(*path);
  if (const auto path = keywords.take("poses")) inputs.posesPath = pathOf(*path);
  if (const auto origin = keywords.take("sensor_origin"))
    inputs.sensorOrigin = vectorOf(*origin, "sensor_origin");
  takeChoice<tools::CloudFrame>(keywords, "cloud_frame",
                                {{"map", tools::CloudFrame::Map}, {"sensor", tools::CloudFrame::Sensor}},
                                inputs.cloudFrame);
  keywords.take("standing_still", inputs.standingStill);
  takeChosenScans(keywords, inputs.choice);
  takePings(keywords, inputs.pings);
  keywords.take("threads", build.threads);
  keywords.take("strict", build.strict);
  if (map.is_none() && build.ontoPath.empty() && build.map.configPath.empty())
    throw std::invalid_argument("map: must be the name or the class of a map, without config and onto");
  if (!map.is_none()) build.map.mapName = aliasOf(map);
  return build;
}

/// The kind of map whose options the keywords are. @throws as buildInMemory(), for another library's map
std::string kindOf(const tools::BuildOptions& build)
{
  if (!build.map.mapName.empty()) return build.map.mapName;
  const auto map = build.map.configPath.empty() ? loadMapFile(build.ontoPath)
                                                : tools::createMap(tools::readMapDefinition(build.map));
  if (const auto learned = std::dynamic_pointer_cast<CLearnedMap>(map)) return learned->alias();
  throw std::runtime_error((build.map.configPath.empty() ? build.ontoPath : build.map.configPath) +
                           ": its map is a " + map->GetRuntimeClass()->className +
                           ", not one of this library's maps");
}

/// Damage is worth a warning: the map is that of what could be read.
void tellReport(const tools::BuildReport& report)
{
  Messages messages;
  const auto warn = [](const std::string& text)
  {
    if (PyErr_WarnEx(PyExc_RuntimeWarning, text.c_str(), 1) != 0) throw py::error_already_set();
  };
  for (const std::string& note : report.notes) messages.emplace_back(20, note);
  for (const tools::InputReport& input : report.inputs)
  {
    for (const std::string& note : input.notes) messages.emplace_back(20, input.path + ": " + note);
    for (const std::string& damage : input.damages) warn(input.path + ": cut short or damaged: " + damage);
  }
  std::stringstream leftOut;
  tools::printLeftOut(report.scans, leftOut);
  for (std::string line; std::getline(leftOut >> std::ws, line);) messages.emplace_back(20, line);
  logMessages(messages);
}

/// The file that a message names, or the first one.
std::string fileMeant(const std::string& message, const tools::BuildOptions& build)
{
  std::vector<std::string> paths = build.inputs.paths;
  paths.insert(paths.end(), {build.ontoPath, build.inputs.posesPath, build.map.configPath});
  for (const std::string& path : paths)
    if (!path.empty() && message.find(path) != std::string::npos) return path;
  return paths.front();
}

py::object build(const py::object& log, const py::object& map, const py::kwargs& arguments)
{
  Keywords keywords(arguments);
  Listener listener(keywords.take("progress").value_or(py::none()));
  tools::BuildOptions options = takeBuildOptions(log, map, keywords);
  if (options.inputs.paths.empty()) throw std::invalid_argument("log: names no file");
  options.inputs.shouldStop = [&] { return listener.shouldStop(); };
  tools::BuiltMap built;
  Messages messages;
  try
  {
    options.map.settings = settingsOf(kindOf(options), keywords.left());
    const ReleasedGil released;
    const CollectedMessages collected(messages);
    const auto prepare = [](mrpt::maps::CMetricMap& made)
    {
      if (auto* learned = dynamic_cast<CLearnedMap*>(&made)) redirectMessages(*learned);
    };
    built = tools::buildInMemory(
        options, [&](const tools::Progress& progress) { listener.show(progress); }, prepare);
  }
  catch (const tools::UsageError& error)
  {
    listener.rethrow();
    throw std::invalid_argument(withoutFlag(error.what()));
  }
  catch (const std::runtime_error& error)
  {
    listener.rethrow();
    const std::string message = compat::messageOf(error);
    throw FileError(message, fileMeant(message, options));
  }
  listener.rethrow();
  logMessages(messages);
  tellReport(built.report);
  auto object = objectOf(std::dynamic_pointer_cast<CLearnedMap>(built.map));
  object->report = tools::reportJson(built.report).dump();
  return py::cast(std::move(object));
}

// ---- Evaluation

/// Centres of cells, and which of them are occupied, as a truth.
tools::Truth truthOf(const py::tuple& truth)
{
  if (truth.size() != 2) throw std::invalid_argument("truth: must be a path, or (centres, occupied)");
  const Vectors centres(truth[0], "centres");
  const std::vector<bool> occupied = maskOf(truth[1], "occupied", centres.size());
  std::vector<tools::TrueCell> cells;
  cells.reserve(centres.size());
  for (size_t i = 0; i < centres.size(); ++i) cells.push_back({centres[i], occupied[i]});
  return tools::truthOfCells(std::move(cells), "truth");
}

py::object evaluate(const MapObject& map, const py::object& truth, const py::object& surface,
                    const py::object& thresholdsGiven)
{
  const std::vector<double> thresholds =
      thresholdsGiven.is_none() ? std::vector<double>{0.7} : numbersOf(thresholdsGiven, "thresholds");
  for (const double threshold : thresholds)
    if (!(threshold >= 0 && threshold <= 1))
      throw std::invalid_argument("thresholds: must be numbers from 0 to 1");
  const bool isGiven = py::isinstance<py::tuple>(truth);
  const std::string path = isGiven ? "" : pathOf(truth);
  const std::string surfacePath = surface.is_none() ? "" : pathOf(surface);
  tools::Truth known = isGiven ? truthOf(truth) : tools::Truth();
  const std::string scores = map.read(
      [&](const CLearnedMap& scored)
      {
        if (!isGiven) known = withFile(path, [&] { return tools::readTruth(path); });
        if (!surfacePath.empty()) withFile(surfacePath, [&] { tools::readSurface(surfacePath, known); });
        tools::OpenedMap opened;
        opened.map = map.pointer();
        opened.cells = tools::cellsOf(map.pointer());
        try
        {
          return tools::scoresJson(tools::scoreMap(opened, scored.alias(), known, thresholds)).dump();
        }
        catch (const std::runtime_error& error)
        {
          throw std::invalid_argument(error.what());  // the map and the truth do not go together
        }
      });
  return py::module_::import("json").attr("loads")(scores);
}

constexpr const char* kBuildDoc = R"(build(log, map='bgk', **keywords)
--

Build a map from logs, as `lamap build` does: the same inputs, the same checks, the same map byte for byte.

log   a path or a list of them: .rawlog, .simplemap, .pcd files or folders of them, .graph, .csv of sonar pings
map   "bgk", "gp", "hilbert" or "overlapping", or one of the classes; None with `config` or `onto`

Keywords, each as the flag of `lamap build` of this name:
config, onto, poses     paths: an .ini file, a saved map to continue, better poses
sensor_origin           (3,) [m]
cloud_frame             "map" or "sensor": the frame of the points in .pcd files
standing_still          `--static`
sensors                 labels of the sensors to use; every: use every Nth observation
from_time, to_time      [s] from the log's first time stamp, seconds since 1970, or a date as text
ping_beam [degrees], ping_angles, ping_threshold, ping_dead_zone [m], ping_separation [m], ping_echoes
threads                 0: as many as the machine has
strict                  raise at the first scan that cannot be read or learned
progress                called with (done, expected, input) from time to time
All others are options of the map.

Notes go to logging.getLogger("lamap"); `report` of the map has them all. A log that is cut short gives a
RuntimeWarning and the map of what could be read. Ctrl-C raises KeyboardInterrupt within one scan.)";

constexpr const char* kEvaluateDoc = R"(evaluate(map, truth, surface=None, thresholds=None)
--

Score a map against a truth, as `lamap eval` does.

truth       path of a .csv with x,y,z,label or of a map; or a tuple (centres (N, 3) [m], occupied (N,) of bool)
surface     path of a .csv with points on surfaces, to which distances are measured
thresholds  probabilities at which precision and recall are given; None: 0.7

Return a dict: what `lamap eval --json` prints for one map.)";
}  // namespace

void addCommands(py::module_& module)
{
  module.def("build", build, kBuildDoc, "log"_a, "map"_a = "bgk");
  module.def("evaluate", evaluate, kEvaluateDoc, "map"_a, "truth"_a, "surface"_a = py::none(),
             "thresholds"_a = py::none());
}

}  // namespace lamap::python
