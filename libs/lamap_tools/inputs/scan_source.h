#pragma once

#include <lamap_core/scan/scan.h>
#include <lamap_tools/inputs/cloud_frame_watch.h>
#include <lamap_tools/inputs/ping_file.h>
#include <lamap_tools/inputs/scan_choice.h>
#include <mrpt/obs/CObservation.h>
#include <mrpt/poses/CPose3D.h>
#include <mrpt/poses/CPose3DPDF.h>

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace lamap::tools
{
/// Which scan of its input one is, for reports.
struct ScanPlace
{
  std::string input;  ///< the path as it was given
  size_t number = 0;  ///< among all items of the input, chosen or not, from 1; 0: not known
  std::optional<mrpt::Clock::time_point> time{};  ///< where the input states one
};
/// "number 5 of log.rawlog, at 12.500 s since 1970"; empty where it is not known
[[nodiscard]] std::string textOf(const ScanPlace& place);

/// An observation and where the robot was.
struct ObservedScan
{
  mrpt::obs::CObservation::Ptr observation;
  mrpt::poses::CPose3D robotPose_map;
  mrpt::poses::CPose3DPDF::ConstPtr
      uncertainPose_map{};  ///< the same pose with its covariance; null: not known
  ScanPlace place{};
};

/// Rays that no observation of MRPT holds.
struct PointScan
{
  std::string kind;  ///< what it was read from, for reports: "PCD file", "graph scan", "sonar ping"
  Scan scan;
  std::optional<mrpt::Clock::time_point> time{};  ///< where its file states one
  std::string name{};                             ///< of its file, where it has one to itself
  ScanPlace place{};
};

/// Something that is not inserted, and why.
struct LeftOutScan
{
  std::string kind;
  std::string reason;
  mrpt::obs::CObservation::Ptr observation{};  ///< null: it is not an observation
  ScanPlace place{};
};

using ScanItem = std::variant<ObservedScan, PointScan, LeftOutScan>;

/// Which scan of its input it is.
[[nodiscard]] const ScanPlace& placeOf(const ScanItem& item);

/// @return why the pose that a scan was made from cannot be used; empty if it can
[[nodiscard]] std::string reasonAgainstPose(const ObservedScan& scan);
[[nodiscard]] std::string reasonAgainstPose(const PointScan& scan);
[[nodiscard]] inline std::string reasonAgainstPose(const LeftOutScan& /*scan*/)
{
  return "";
}

/// An object's class without its namespace, for reports.
[[nodiscard]] std::string shortClassName(const mrpt::rtti::CObject& object);

/** A deep copy for another thread or map, because MRPT's observations load external files and cache results
 * even when they are const. */
[[nodiscard]] ScanItem ownCopyOf(const ScanItem& item);

/** The scans of one input, in its order. Belongs to one thread. */
class ScanSource
{
 public:
  virtual ~ScanSource() = default;

  /// The path as it was given.
  [[nodiscard]] const std::string& path() const { return path_; }
  /// Number of items of this input, chosen or not, as far as is known.
  [[nodiscard]] size_t expectedItems() const { return expectedItems_; }
  /// Number of items, chosen or not, that next() has met.
  [[nodiscard]] size_t readItems() const { return readItems_; }
  /// The next item that is chosen; nothing at the end, or if it was asked to stop while it looked for one.
  /// @throws std::runtime_error naming the file if it cannot be read.
  [[nodiscard]] std::optional<ScanItem> next();
  /// Its sensors and its first time stamp, whatever is chosen.
  [[nodiscard]] const LogContents& contents() const { return contents_; }
  /// Leaves out what is not chosen. @param chooser  shared by all inputs, for it counts through them
  void choose(std::shared_ptr<ScanChooser> chooser, std::function<bool()> shouldStop);
  /// Nothing: all is taken.
  [[nodiscard]] const std::shared_ptr<ScanChooser>& chooser() const { return chooser_; }
  /// What could not be read, because a file was cut short or is damaged, as far as next() has met it.
  [[nodiscard]] const std::vector<std::string>& damages() const { return damages_; }
  /// Whether the poses are a robot's odometry as the log holds it, which drifts.
  [[nodiscard]] bool posesAreOdometry() const { return posesAreOdometry_; }
  /// Remarks for the report on how this input was read: on its poses.
  [[nodiscard]] const std::vector<std::string>& notes() const { return notes_; }
  /// The same, on its readings.
  [[nodiscard]] const std::vector<std::string>& readingNotes() const { return readingNotes_; }
  /// Remarks on this input and others together, which they name.
  [[nodiscard]] const std::vector<std::string>& jointNotes() const { return jointNotes_; }

 protected:
  explicit ScanSource(std::string path) : path_(std::move(path)) {}
  ScanSource(const ScanSource&) = delete;
  ScanSource& operator=(const ScanSource&) = delete;

  /// As next(), whatever is chosen.
  [[nodiscard]] virtual std::optional<ScanItem> nextOfAll() = 0;

  std::string path_;
  LogContents contents_;
  size_t expectedItems_ = 0;
  std::vector<std::string> damages_;
  std::vector<std::string> notes_;
  std::vector<std::string> readingNotes_;
  std::vector<std::string> jointNotes_;
  bool posesAreOdometry_ = false;

 private:
  [[nodiscard]] bool isChosen(const ScanItem& item);

  std::shared_ptr<ScanChooser> chooser_;
  std::function<bool()> shouldStop_;
  size_t readItems_ = 0;
};

struct InputOptions
{
  /// In this order; one named twice is read twice. A folder stands for its PCD files, in natural order (_2
  /// before _10).
  std::vector<std::string> paths;
  /// See readPoseFile(). For rawlogs the robot's poses over time; for PCD files they are in place of
  /// VIEWPOINT: by time where the names of all files are times of poses, else the k-th for the k-th file.
  /// Empty: none.
  std::string posesPath;
  /// Where the sensor is [m]: of PCD files in the frame of VIEWPOINT or of the pose that replaces it, of
  /// sonar pings in the robot's.
  Eigen::Vector3d sensorOrigin = Eigen::Vector3d::Zero();
  CloudFrame cloudFrame = CloudFrame::Map;
  PingRules pings;  ///< of `.csv` files
  /// For rawlogs and pings: the robot stood still at the map's origin, whatever the log says.
  bool standingStill = false;
  /// To look at rawlogs without poses: what they hold is left out, with that reason, instead of an error.
  /// Given poses must cover some of it all the same.
  bool evenWithoutPoses = false;
  /// What of it is used.
  ScanChoice choice;
  /// Called from time to time while a log is surveyed.
  std::function<bool()> shouldStop = [] { return false; };
};

/** Opens inputs and surveys them. Simple maps are held in memory; of other inputs, only poses and names are.
 *
 * - `.rawlog`: every observation but odometry. The robot's poses are `posesPath` if it is given, else the
 * log's actions composed from the identity if it has any, else its CObservationOdometry. A pose composed from
 * actions holds at the time of the sensory frame that follows (MRPT stamps an action in the middle of its
 * movement): at the action's time if that lies among the frame's observations, else at its earliest
 * observation. Poses are interpolated at each observation's time; an observation outside the time the poses
 * cover, or without a time, is left out, or, where poses come from actions, takes the pose of its frame. A
 * log without poses is read only if all it holds is a single observation or frame, which is then at the
 * origin. Given poses whose times are 0, 1, 2, … where the log's are others are steps, as icp-slam
 * writes them: the k-th is that of the k-th frame after an action, or of the k-th observation of a log
 * without frames, odometry included.
 * - `.simplemap`, `.simplemap.gz`: every observation, at the mean of its pose.
 * - `.pcd`, folders of them (hidden files are no scans): each file a scan; one that cannot be read is a
 * damage of the input. A name is a time if all of it is a number: seconds, or whole milli-, micro- or
 * nanoseconds since 1970. A folder whose names are times is read in their order. A point no farther from the
 * sensor than the numbers can tell, or than 1 mm, is put on it: it is no return.
 * - `.graph`: each scan of an OctoMap scan graph.
 * - `.csv`: the pings of a scanning sonar, see PingFile, at the poses of `posesPath`, interpolated at their
 * times; a ping outside the time that they cover is left out.
 *
 * What is not chosen (InputOptions::choice) is left out without being counted.
 *
 * @throws UsageError if an option does not go with the inputs, std::runtime_error naming the file if one
 * cannot be read at all, holds no pose, or the number of poses is not that of the PCD files that take them
 * one by one; or naming a chosen sensor that none of them has. */
[[nodiscard]] std::vector<std::unique_ptr<ScanSource>> openInputs(const InputOptions& options);

/// Whether the name is one of a log, whether or not lamap reads this kind (`.bag`), or of a folder.
[[nodiscard]] bool isNameOfLog(const std::string& path);

/// Whether a name comes before another one, with the numbers in it compared as numbers.
[[nodiscard]] bool inNaturalOrder(const std::string& a, const std::string& b);

}  // namespace lamap::tools
