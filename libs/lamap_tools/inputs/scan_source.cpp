#include <lamap_tools/inputs/scan_source.h>

#include <lamap_mrpt/compat/mrpt_compat.h>
#include <lamap_mrpt/observations/isometry.h>
#include <lamap_tools/files/file_names.h>
#include <lamap_tools/files/text_fields.h>
#include <lamap_tools/files/usage_error.h>
#include <lamap_tools/inputs/graph_file.h>
#include <lamap_tools/inputs/pcd_source.h>
#include <lamap_tools/inputs/ping_source.h>
#include <lamap_tools/inputs/pose_track.h>
#include <lamap_tools/inputs/rawlog_source.h>
#include <lamap_tools/inputs/simple_map_file.h>
#include <lamap_tools/report/counted.h>
#include <mrpt/core/format.h>
#include <mrpt/img/CImage.h>
#include <mrpt/maps/CSimpleMap.h>
#include <mrpt/obs/CRawlog.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/poses/CPose3DPDF.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <stdexcept>

namespace lamap::tools
{
namespace fs = std::filesystem;

namespace
{
enum class InputKind
{
  Rawlog,
  SimpleMap,
  Pcd,
  Graph,
  Pings
};

/// How to make a log of a bag, which lamap does not read; nothing for anything else.
std::optional<std::string> adviceOnBag(const std::string& path)
{
  const bool isFolder = fs::is_directory(path);
  if (isFolder ? fs::exists(fs::path(path) / "metadata.yaml")
               : endsWith(path, ".db3") || endsWith(path, ".mcap"))
    return path +
           ": a ROS 2 bag, which lamap does not read. MOLA makes a simple map of it, with better poses than "
           "odometry (mola-lidar-odometry-cli --input-rosbag2 BAG --output-simplemap log.simplemap); the ROS "
           "2 package rosbag2rawlog makes a .rawlog";
  if (endsWith(path, ".bag"))
    return path +
           ": a ROS 1 bag, which lamap does not read. MRPT's rosbag2rawlog makes a .rawlog of it "
           "(rosbag2rawlog -f FRAME -c CONFIG.yml -o log.rawlog BAG)";
  return std::nullopt;
}

/// Nothing for a name that is of no kind.
std::optional<InputKind> kindByName(const std::string& path)
{
  if (fs::is_directory(path) || endsWith(path, ".pcd")) return InputKind::Pcd;
  if (endsWith(path, ".rawlog") || endsWith(path, ".rawlog.gz")) return InputKind::Rawlog;
  if (endsWith(path, ".simplemap") || endsWith(path, ".simplemap.gz")) return InputKind::SimpleMap;
  if (endsWith(path, ".graph")) return InputKind::Graph;
  if (endsWith(path, ".csv")) return InputKind::Pings;
  return std::nullopt;
}

InputKind kindOf(const std::string& path)
{
  if (!fs::exists(path)) throw std::runtime_error(path + ": does not exist");
  if (const auto advice = adviceOnBag(path)) throw UsageError(*advice);
  if (const auto kind = kindByName(path)) return *kind;
  throw UsageError(
      path +
      ": not a known kind of input; expected .rawlog, .simplemap, .simplemap.gz, .pcd, a folder of "
      ".pcd files, .graph or .csv (pings of a sonar)");
}

constexpr const char* kGraphScan = "graph scan";
constexpr const char* kBadPose = "its pose is NaN or infinite";

class SimpleMapSource : public ScanSource
{
 public:
  SimpleMapSource(const std::string& path, const std::function<bool()>& shouldStop)
      : ScanSource(path), map_(readSimpleMap(path, shouldStop))
  {
    for (size_t i = 0; i < map_.size(); ++i) expectedItems_ += compat::keyframeAt(map_, i).frame->size();
    for (size_t i = 0; i < map_.size(); ++i)
      for (const auto& observation : *compat::keyframeAt(map_, i).frame) contents_.include(*observation);
    notes_.push_back(counted(map_.size(), "pose") + " of the simple map");
  }

  [[nodiscard]] std::optional<ScanItem> nextOfAll() override
  {
    if (frame_ == 0 && observation_ == 0)
      mrpt::img::CImage::setImagesPathBase(mrpt::obs::CRawlog::detectImagesDirectory(path_));
    while (frame_ < map_.size())
    {
      const auto keyframe = compat::keyframeAt(map_, frame_);
      if (observation_ < keyframe.frame->size())
        return ObservedScan{keyframe.frame->getObservationByIndex(observation_++),
                            keyframe.pose->getMeanVal(), keyframe.pose};
      ++frame_;
      observation_ = 0;
    }
    return std::nullopt;
  }

 private:
  mrpt::maps::CSimpleMap map_;
  size_t frame_ = 0;
  size_t observation_ = 0;
};

class GraphSource : public ScanSource
{
 public:
  explicit GraphSource(const std::string& path) : ScanSource(path), file_(path)
  {
    expectedItems_ = file_.size();
    contents_.sensors = {kGraphScan};
    notes_ = {"poses of the scan graph"};
  }

  [[nodiscard]] std::optional<ScanItem> nextOfAll() override
  {
    auto scan = file_.next();
    if (file_.damage()) damages_ = {*file_.damage()};
    if (!scan) return std::nullopt;
    return PointScan{kGraphScan, std::move(*scan)};
  }

 private:
  GraphFile file_;
};

/// @throws UsageError if an option does not go with the kinds of input.
void requireFittingOptions(const InputOptions& options, const std::vector<InputKind>& kinds)
{
  const auto has = [&](InputKind kind) { return std::find(kinds.begin(), kinds.end(), kind) != kinds.end(); };
  if (!options.posesPath.empty())
  {
    if (has(InputKind::SimpleMap) || has(InputKind::Graph))
      throw UsageError("--poses: simple maps and scan graphs have poses of their own");
    if ((has(InputKind::Rawlog) || has(InputKind::Pings)) && has(InputKind::Pcd))
      throw UsageError(
          "--poses: give PCD files by themselves, because their poses and those of logs mean different "
          "things");
    if (options.standingStill) throw UsageError("--poses and --static exclude each other");
  }
  if (options.standingStill && !has(InputKind::Rawlog) && !has(InputKind::Pings))
    throw UsageError("--static: is for rawlogs and pings only");
  if (has(InputKind::Pings) && options.posesPath.empty() && !options.standingStill &&
      !options.evenWithoutPoses)
    throw UsageError(
        "--poses: pings in a .csv need poses by time (or --static if the sonar stood still at the origin)");
  if (!options.sensorOrigin.isZero() && !has(InputKind::Pcd) && !has(InputKind::Pings))
    throw UsageError("--sensor-origin: is for PCD files and pings only");
  options.pings.validate();
  if (!has(InputKind::Pings) && !(options.pings == PingRules()))
    throw UsageError("the flags that begin with --ping- are for .csv files with pings only");
  if (options.cloudFrame == CloudFrame::Sensor && !has(InputKind::Pcd))
    throw UsageError("--cloud-frame: is for PCD files only");
}
}  // namespace

std::string textOf(const ScanPlace& place)
{
  if (place.number == 0) return "";
  std::string text = "number " + std::to_string(place.number) + " of " + place.input;
  if (place.time) text += mrpt::format(", at %.3f s since 1970", mrpt::Clock::toDouble(*place.time));
  return text;
}

const ScanPlace& placeOf(const ScanItem& item)
{
  return std::visit([](const auto& scan) -> const ScanPlace& { return scan.place; }, item);
}

std::string reasonAgainstPose(const ObservedScan& scan)
{
  return isometryOf(scan.robotPose_map).matrix().allFinite() ? "" : kBadPose;
}

std::string reasonAgainstPose(const PointScan& scan)
{
  return scan.scan.sensorPose_map.matrix().allFinite() ? "" : kBadPose;
}

namespace
{
std::optional<mrpt::Clock::time_point> timeOf(const ScanItem& item)
{
  if (const auto* points = std::get_if<PointScan>(&item)) return points->time;
  const auto* observed = std::get_if<ObservedScan>(&item);
  const auto& observation =
      observed != nullptr ? observed->observation : std::get<LeftOutScan>(item).observation;
  if (!observation || observation->timestamp == INVALID_TIMESTAMP) return std::nullopt;
  return observation->timestamp;
}
}  // namespace

std::optional<ScanItem> ScanSource::next()
{
  while (auto item = nextOfAll())
  {
    ++readItems_;
    std::visit([this, time = timeOf(*item)](auto& scan) { scan.place = {path_, readItems_, time}; }, *item);
    if (!chooser_ || isChosen(*item)) return item;
    if (shouldStop_()) return std::nullopt;
  }
  return std::nullopt;
}

void ScanSource::choose(std::shared_ptr<ScanChooser> chooser, std::function<bool()> shouldStop)
{
  chooser_ = std::move(chooser);
  shouldStop_ = std::move(shouldStop);
}

bool ScanSource::isChosen(const ScanItem& item)
{
  if (const auto* observed = std::get_if<ObservedScan>(&item))
    return chooser_->takes(*observed->observation, contents_);
  if (const auto* points = std::get_if<PointScan>(&item))
    return chooser_->takes(points->kind, points->time, contents_);
  const auto& leftOut = std::get<LeftOutScan>(item);
  // What is no observation is reported in any case.
  return !leftOut.observation || chooser_->takes(*leftOut.observation, contents_);
}

namespace
{
std::vector<std::unique_ptr<ScanSource>> openAllOf(const InputOptions& options)
{
  std::vector<InputKind> kinds;
  for (const std::string& path : options.paths) kinds.push_back(kindOf(path));
  requireFittingOptions(options, kinds);

  std::vector<TimedPose> poses;
  if (!options.posesPath.empty()) poses = readPoseFile(options.posesPath);
  std::vector<std::string> pcdPaths;
  for (size_t i = 0; i < kinds.size(); ++i)
    if (kinds[i] == InputKind::Pcd) pcdPaths.push_back(options.paths[i]);
  auto pcdSources = openPcdSources(pcdPaths, poses, options);
  auto nextPcd = pcdSources.begin();

  std::shared_ptr<const PoseTrack> track;
  if (!poses.empty() && pcdPaths.empty())
  {
    if (poses.front().time == INVALID_TIMESTAMP)
      throw std::runtime_error(
          options.posesPath +
          ": its poses have no times (KITTI: twelve numbers per line), so they do not tell "
          "where a log's observations were made; expected lines that begin with a time");
    track = std::make_shared<const PoseTrack>(poses);
  }
  std::vector<std::unique_ptr<ScanSource>> sources;
  for (size_t i = 0; i < kinds.size(); ++i)
  {
    const std::string& path = options.paths[i];
    if (kinds[i] == InputKind::Rawlog)
      sources.push_back(openRawlogSource(path, track, options));
    else if (kinds[i] == InputKind::SimpleMap)
      sources.push_back(std::make_unique<SimpleMapSource>(path, options.shouldStop));
    else if (kinds[i] == InputKind::Graph)
      sources.push_back(std::make_unique<GraphSource>(path));
    else if (kinds[i] == InputKind::Pings)
      sources.push_back(openPingSource(path, track, options));
    else
      sources.push_back(std::move(*nextPcd++));
  }
  return sources;
}
}  // namespace

std::vector<std::unique_ptr<ScanSource>> openInputs(const InputOptions& options)
{
  if (options.choice.isAll()) return openAllOf(options);
  const auto chooser = std::make_shared<ScanChooser>(options.choice);
  auto sources = openAllOf(options);
  if (options.shouldStop()) return sources;  // they may not be surveyed
  std::vector<LogContents> contents;
  for (const auto& source : sources) contents.push_back(source->contents());
  chooser->requireSensors(contents, firstFewOf(options.paths));
  for (const auto& source : sources) source->choose(chooser, options.shouldStop);
  return sources;
}

bool inNaturalOrder(const std::string& a, const std::string& b)
{
  const auto isDigit = [](char letter) { return std::isdigit(static_cast<unsigned char>(letter)) != 0; };
  size_t i = 0;
  size_t j = 0;
  while (i < a.size() && j < b.size())
  {
    if (!isDigit(a[i]) || !isDigit(b[j]))
    {
      if (a[i] != b[j]) return a[i] < b[j];
      ++i;
      ++j;
      continue;
    }
    const auto numberAt = [&](const std::string& text, size_t& at)
    {
      while (at + 1 < text.size() && text[at] == '0' && isDigit(text[at + 1])) ++at;
      const size_t begin = at;
      while (at < text.size() && isDigit(text[at])) ++at;
      return text.substr(begin, at - begin);
    };
    const std::string numberA = numberAt(a, i);
    const std::string numberB = numberAt(b, j);
    if (numberA.size() != numberB.size()) return numberA.size() < numberB.size();
    if (numberA != numberB) return numberA < numberB;
  }
  if (i == a.size() && j == b.size()) return a < b;  // equal but for leading zeros
  return i == a.size();
}

bool isNameOfLog(const std::string& path)
{
  return kindByName(path) || adviceOnBag(path);
}

std::string shortClassName(const mrpt::rtti::CObject& object)
{
  const std::string name = object.GetRuntimeClass()->className;
  return name.substr(name.rfind(':') + 1);  // all of it where there is no colon
}

ScanItem ownCopyOf(const ScanItem& item)
{
  const auto* observed = std::get_if<ObservedScan>(&item);
  if (observed == nullptr) return item;
  ObservedScan copy = *observed;
  copy.observation =
      std::dynamic_pointer_cast<mrpt::obs::CObservation>(observed->observation->duplicateGetSmartPtr());
  return copy;
}

}  // namespace lamap::tools
