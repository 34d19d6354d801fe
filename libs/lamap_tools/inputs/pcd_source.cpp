#include <lamap_mrpt/observations/isometry.h>
#include <lamap_tools/files/file_names.h>
#include <lamap_tools/files/text_fields.h>
#include <lamap_tools/inputs/cloud_frame_watch.h>
#include <lamap_tools/inputs/pcd_file.h>
#include <lamap_tools/inputs/pcd_source.h>
#include <lamap_tools/report/counted.h>
#include <mrpt/core/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <map>
#include <new>
#include <stdexcept>
#include <tuple>
#include <utility>

namespace lamap::tools
{
namespace fs = std::filesystem;

namespace
{
constexpr const char* kPcdFile = "PCD file";

struct PcdInput
{
  std::string path;                             ///< one that was given
  std::vector<std::string> files;               ///< it, or what the folder holds
  std::vector<std::optional<TimedPose>> poses;  ///< of the files, in place of VIEWPOINT; empty: none
  std::string posesOrigin = "VIEWPOINT";
  std::vector<std::string> notes;
};

std::string nameOf(const std::string& path)
{
  return fs::path(path).filename().string();
}

PcdInput inputOf(const std::string& path)
{
  PcdInput input;
  input.path = path;
  if (!fs::is_directory(path))
  {
    input.files = {path};
    return input;
  }
  size_t hidden = 0;
  for (const auto& entry : fs::directory_iterator(path))
  {
    const std::string file = entry.path().string();
    if (entry.is_directory() || !endsWith(file, ".pcd")) continue;
    // Other systems' notes on a file, and what a writer left that did not come to its end.
    if (nameOf(file).front() == '.')
      ++hidden;
    else
      input.files.push_back(file);
  }
  const std::string left = "left out: " + counted(hidden, "hidden file") + ", whose name begins with a dot";
  if (input.files.empty())
    throw std::runtime_error(path + ": a folder without .pcd files" + (hidden > 0 ? "; " + left : ""));
  if (hidden > 0) input.notes.push_back(left);
  std::sort(input.files.begin(), input.files.end(), inNaturalOrder);
  return input;
}

/// What a file's name says if all of it is a number: seconds, or whole milli-, micro- or nanoseconds of our
/// age.
struct NameTime
{
  double time_s = 0;
  bool mayCount = false;  ///< it may also be the number of the file
};

std::optional<NameTime> timeInName(const std::string& path)
{
  const std::string name = fs::path(path).stem().string();
  const bool isPlain = name.find_first_not_of("0123456789.") == std::string::npos;
  const auto number = numberIn<double>(name);
  if (!isPlain || !number) return std::nullopt;
  if (name.find('.') != std::string::npos) return NameTime{*number, false};
  constexpr double kLatest_s = 1e11;
  double time_s = *number;
  while (time_s >= kLatest_s) time_s /= 1000;
  constexpr double kMostFiles = 1e8;
  return NameTime{time_s, time_s < kMostFiles};
}

/// The poses by their times [s]; of several with the same time, the last.
class PosesByTime
{
 public:
  explicit PosesByTime(const std::vector<TimedPose>& poses)
  {
    for (const TimedPose& pose : poses)
      if (pose.time != INVALID_TIMESTAMP) poses_.insert_or_assign(mrpt::Clock::toDouble(pose.time), pose);
  }

  [[nodiscard]] std::optional<TimedPose> at(double time_s) const
  {
    constexpr double kSame_s = 1e-4;  // names and pose files have different numbers of decimals
    auto nearest = poses_.lower_bound(time_s);
    if (nearest != poses_.begin() &&
        (nearest == poses_.end() || time_s - std::prev(nearest)->first < nearest->first - time_s))
      --nearest;
    if (nearest == poses_.end() || std::abs(nearest->first - time_s) > kSame_s) return std::nullopt;
    return nearest->second;
  }

 private:
  std::map<double, TimedPose> poses_;
};

/** Gives each file the pose whose time its name is.
 * @return whether the names are times: all of them are, or most of numbers that are too large to count files
 */
bool takePosesByTime(const PosesByTime& poses, std::vector<PcdInput>& inputs)
{
  size_t files = 0;
  size_t matched = 0;
  bool mayCount = false;
  for (PcdInput& input : inputs)
    for (const std::string& file : input.files)
    {
      const auto time = timeInName(file);
      if (!time) return false;
      const auto pose = poses.at(time->time_s);
      mayCount |= time->mayCount;
      ++files;
      matched += pose ? 1 : 0;
      input.poses.push_back(pose);
    }
  return matched == files || (!mayCount && 2 * matched > files);
}

/// What to say where names look like times, but poses were not taken by them; nothing where they do not.
std::optional<std::string> noteOnNamesOf(const PcdInput& input, const std::vector<TimedPose>& poses)
{
  std::vector<double> names_s;
  for (const std::string& file : input.files)
  {
    const auto time = timeInName(file);
    if (!time || time->mayCount) return std::nullopt;
    names_s.push_back(time->time_s);
  }
  std::vector<double> poses_s;
  for (const TimedPose& pose : poses)
    if (pose.time != INVALID_TIMESTAMP) poses_s.push_back(mrpt::Clock::toDouble(pose.time));
  if (names_s.empty() || poses_s.empty()) return std::nullopt;
  const auto spanText = [](const std::vector<double>& times_s)
  {
    const auto [first, last] = std::minmax_element(times_s.begin(), times_s.end());
    return mrpt::format("%.4f to %.4f s", *first, *last);
  };
  return "its names look like times, " + spanText(names_s) + ", but are not those of the poses, " +
         spanText(poses_s) + ": are the poses those of another log?";
}

/// Puts the files of a folder in the order of their times, and tells if it was another one.
void sortByTime(PcdInput& input)
{
  std::vector<std::pair<std::string, std::optional<TimedPose>>> files;
  for (size_t i = 0; i < input.files.size(); ++i) files.emplace_back(input.files[i], input.poses[i]);
  const auto timeOf = [](const auto& file) { return timeInName(file.first)->time_s; };
  const auto earlier = [&](const auto& a, const auto& b) { return timeOf(a) < timeOf(b); };
  const auto unordered = std::is_sorted_until(files.begin(), files.end(), earlier);
  if (unordered == files.end()) return;
  input.notes.push_back("the natural order of the names and their times disagree (" +
                        nameOf(std::prev(unordered)->first) + " comes before " + nameOf(unordered->first) +
                        "): the files are read in the order of their times");
  std::stable_sort(files.begin(), files.end(), earlier);
  for (size_t i = 0; i < files.size(); ++i) std::tie(input.files[i], input.poses[i]) = files[i];
}

/// @throws std::runtime_error if there are not as many poses as files
void takePosesInOrder(const std::vector<TimedPose>& poses, const std::string& posesPath,
                      std::vector<PcdInput>& inputs)
{
  size_t files = 0;
  for (const PcdInput& input : inputs) files += input.files.size();
  if (poses.size() != files)
    throw std::runtime_error(posesPath + ": holds " + counted(poses.size(), "pose") + " for " +
                             counted(files, "PCD file") +
                             "; the k-th pose is for the k-th file, unless the names of the files "
                             "are the times of poses, e.g. 1305031102.175304.pcd");
  auto next = poses.begin();
  for (PcdInput& input : inputs)
  {
    input.poses.assign(next, next + static_cast<std::ptrdiff_t>(input.files.size()));
    next += static_cast<std::ptrdiff_t>(input.files.size());
  }
  const auto earlier = [](const TimedPose& a, const TimedPose& b) { return a.time < b.time; };
  auto first = poses.begin();
  for (PcdInput& input : inputs)
  {
    const auto last = first + static_cast<std::ptrdiff_t>(input.files.size());
    const auto unordered = std::is_sorted_until(first, last, earlier);
    if (unordered != last)
      input.notes.push_back("pose " + std::to_string(unordered - poses.begin() + 1) + " of " + posesPath +
                            " is earlier than the one before it; still, the k-th is for the k-th file");
    first = last;
  }
}

class PcdSource : public ScanSource
{
 public:
  /// What all sources of PCD files share.
  struct Shared
  {
    CloudFrameWatch watch;
    std::vector<std::string> paths;
    std::vector<std::string> wholeFiles;  ///< whose coordinates are whole numbers
  };

  /// @param isLast  and tells what was seen of all
  PcdSource(PcdInput input, const InputOptions& options, std::shared_ptr<Shared> shared, bool isLast)
      : ScanSource(input.path),
        files_(std::move(input.files)),
        poses_(std::move(input.poses)),
        inSensorFrame_(options.cloudFrame == CloudFrame::Sensor),
        sensorOrigin_(options.sensorOrigin),
        shared_(std::move(shared)),
        tellsOfAll_(isLast)
  {
    expectedItems_ = files_.size();
    contents_.sensors = {kPcdFile};
    notes_ = {std::string(inSensorFrame_ ? "clouds in the sensor's frame, poses" : "origins") + " from " +
              input.posesOrigin};
    notes_.insert(notes_.end(), input.notes.begin(), input.notes.end());
  }

  [[nodiscard]] std::optional<ScanItem> nextOfAll() override
  {
    while (next_ < files_.size())
    {
      const size_t i = next_++;
      if (!poses_.empty() && !poses_[i])
        return LeftOutScan{kPcdFile, "no pose has the time that is its name", nullptr};
      try
      {
        return scanOf(i);
      }
      catch (const std::bad_alloc&)
      {
        damages_.push_back(files_[i] + ": not enough memory");
      }
      catch (const std::runtime_error& error)
      {
        // The source's own path is named by whoever reports the damage.
        const std::string text = error.what();
        const std::string own = path_ + ": ";
        damages_.push_back(text.rfind(own, 0) == 0 ? text.substr(own.size()) : text);
      }
    }
    if (std::exchange(tellsOfAll_, false))
    {
      tellSuspicion();
      tellWholeFiles();
    }
    return std::nullopt;
  }

 private:
  void tellSuspicion()
  {
    const auto suspicion = shared_->watch.suspicion();
    if (!suspicion) return;
    if (shared_->paths.size() == 1)
      notes_.push_back(*suspicion);
    else
      jointNotes_.push_back(firstFewOf(shared_->paths) + ": " + *suspicion);
  }

  void tellWholeFiles()
  {
    if (shared_->wholeFiles.empty()) return;
    jointNotes_.push_back(firstFewOf(shared_->wholeFiles) +
                          ": whole numbers (TYPE I or U) as x, y or z are taken to be metres; if they are "
                          "millimetres, say, convert them first");
  }

  PointScan scanOf(size_t i)
  {
    const PcdCloud cloud = readPcdFile(files_[i]);
    if (cloud.isWhole) shared_->wholeFiles.push_back(files_[i]);
    const Eigen::Isometry3d frame =
        poses_.empty() ? viewpointOf(cloud, files_[i]) : isometryOf(poses_[i]->pose_map);
    PointScan points{kPcdFile, {}};
    points.name = files_[i];
    RayFan& fan = points.scan.fans.emplace_back();
    if (inSensorFrame_) points.scan.sensorPose_map = frame;
    fan.centre = inSensorFrame_ ? sensorOrigin_ : frame * sensorOrigin_;
    const Eigen::Vector3d rounding = roundingOf(cloud, frame);
    fan.rays.reserve(cloud.points.size());
    for (const Eigen::Vector3d& point : cloud.points)
    {
      // A missing return that was moved from the sensor's frame to the map's, and rounded there.
      const bool isAtSensor = ((point - fan.centre).cwiseAbs().array() <= rounding.array()).all();
      fan.addReturn(isAtSensor ? fan.centre : point);
    }
    shared_->watch.add(frame, sensorOrigin_, cloud.points);
    return points;
  }

  /// As far as it is needed: the rotations of many files are no rotations.
  /// @throws std::runtime_error naming the file if its rotation is needed and is none
  [[nodiscard]] Eigen::Isometry3d viewpointOf(const PcdCloud& cloud, const std::string& file) const
  {
    Eigen::Isometry3d frame = Eigen::Isometry3d::Identity();
    frame.translation() = cloud.viewpoint;
    if (isUnit(cloud.viewpointRotation))
      frame.linear() = cloud.viewpointRotation.normalized().toRotationMatrix();
    else if (inSensorFrame_ || !sensorOrigin_.isZero(0))
      throw std::runtime_error(file + ": the rotation of VIEWPOINT (qw qx qy qz) has the length " +
                               std::to_string(cloud.viewpointRotation.norm()) + " and not 1, and " +
                               (inSensorFrame_ ? "--cloud-frame sensor" : "--sensor-origin") + " needs it");
    return frame;
  }

  /// How far apart the numbers may put two points that are the same: this one and the sensor.
  [[nodiscard]] Eigen::Vector3d roundingOf(const PcdCloud& cloud, const Eigen::Isometry3d& frame) const
  {
    // Two numbers of three decimals, each half of the last one off; no sensor measures as near.
    constexpr double kThreeDecimals_m = 1e-3 * (1 + 1e-9);
    Eigen::Vector3d rounding = Eigen::Vector3d::Constant(kThreeDecimals_m);
    if (inSensorFrame_) return rounding;
    const Eigen::Vector3d size = frame.translation().cwiseAbs().array() + sensorOrigin_.norm();
    rounding = rounding.cwiseMax(cloud.relativeError * size);
    return poses_.empty() ? rounding.cwiseMax(cloud.relativeError * size + cloud.viewpointError) : rounding;
  }

  std::vector<std::string> files_;
  std::vector<std::optional<TimedPose>> poses_;
  bool inSensorFrame_;
  Eigen::Vector3d sensorOrigin_;
  std::shared_ptr<Shared> shared_;
  bool tellsOfAll_;
  size_t next_ = 0;
};
}  // namespace

std::vector<std::unique_ptr<ScanSource>> openPcdSources(const std::vector<std::string>& paths,
                                                        const std::vector<TimedPose>& poses,
                                                        const InputOptions& options)
{
  std::vector<PcdInput> inputs;
  inputs.reserve(paths.size());
  for (const std::string& path : paths) inputs.push_back(inputOf(path));
  if (!poses.empty() && !inputs.empty())
  {
    const bool byTime = takePosesByTime(PosesByTime(poses), inputs);
    if (byTime)
      for (PcdInput& input : inputs) sortByTime(input);
    else
      takePosesInOrder(poses, options.posesPath, inputs);
    for (PcdInput& input : inputs)
    {
      if (const auto note = byTime ? std::nullopt : noteOnNamesOf(input, poses)) input.notes.push_back(*note);
      input.posesOrigin = std::string("the given file, ") +
                          (byTime ? "by the times that are the names" : "the k-th for the k-th file");
    }
  }
  const auto shared =
      std::make_shared<PcdSource::Shared>(PcdSource::Shared{CloudFrameWatch(options.cloudFrame), paths, {}});
  std::vector<std::unique_ptr<ScanSource>> sources;
  for (PcdInput& input : inputs)
    sources.push_back(
        std::make_unique<PcdSource>(std::move(input), options, shared, &input == &inputs.back()));
  return sources;
}

}  // namespace lamap::tools
