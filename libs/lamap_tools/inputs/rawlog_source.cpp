#include <lamap_tools/inputs/rawlog_source.h>

#include <lamap_tools/inputs/rawlog_file.h>
#include <mrpt/core/format.h>
#include <mrpt/obs/CActionCollection.h>
#include <mrpt/obs/CActionRobotMovement2D.h>
#include <mrpt/obs/CActionRobotMovement3D.h>
#include <mrpt/obs/CObservationOdometry.h>
#include <mrpt/obs/CSensoryFrame.h>

#include <algorithm>
#include <deque>
#include <stdexcept>

namespace lamap::tools
{
using mrpt::obs::CActionCollection;
using mrpt::obs::CObservation;
using mrpt::obs::CObservationOdometry;
using mrpt::obs::CSensoryFrame;
using mrpt::poses::CPose3D;
using Time = mrpt::Clock::time_point;

namespace
{
std::optional<Time> validTime(Time time)
{
  if (time == INVALID_TIMESTAMP) return std::nullopt;
  return time;
}

std::string shortClassName(const mrpt::rtti::CObject& object)
{
  const std::string name = object.GetRuntimeClass()->className;
  const size_t colon = name.rfind(':');
  return colon == std::string::npos ? name : name.substr(colon + 1);
}

/// The movement of an action collection: the 3D one if there is one, else the 2D one with the smallest
/// covariance.
struct Movement
{
  CPose3D increment;
  std::optional<Time> time;
};

std::optional<Movement> movementOf(const CActionCollection& actions)
{
  if (const auto move3D = actions.getActionByClass<mrpt::obs::CActionRobotMovement3D>())
    return Movement{move3D->poseChange.mean, validTime(move3D->timestamp)};
  if (const auto move2D = actions.getBestMovementEstimation())
    return Movement{CPose3D(move2D->poseChange->getMeanVal()), validTime(move2D->timestamp)};
  return std::nullopt;
}

using Frame = std::vector<CObservation::Ptr>;

/// When a pose composed from actions holds: see openInputs().
std::optional<Time> timeOf(const Frame& frame, std::optional<Time> actionTime)
{
  std::optional<Time> earliest;
  std::optional<Time> latest;
  for (const auto& observation : frame)
  {
    const auto time = validTime(observation->timestamp);
    if (!time) continue;
    earliest = earliest ? std::min(*earliest, *time) : *time;
    latest = latest ? std::max(*latest, *time) : *time;
  }
  const bool actionAmongThem = earliest && actionTime && *earliest <= *actionTime && *actionTime <= *latest;
  return actionAmongThem ? actionTime : earliest;
}

/// Walks through a rawlog frame by frame and composes its actions on the way.
class FrameReader
{
 public:
  FrameReader(const std::string& path, const std::optional<RawlogFile::Limit>& limit) : file_(path, limit) {}

  struct Step
  {
    Frame frame;  ///< observations but odometry
    std::vector<TimedPose> odometry;
    std::optional<LeftOutScan> foreign;
    CPose3D actionPose_map;  ///< the actions so far, composed
    std::optional<Time> frameTime;
  };

  /// The next frame, single observation or foreign object; nothing at the end.
  std::optional<Step> next()
  {
    while (const auto entry = file_.next())
    {
      if (const auto* actions = dynamic_cast<const CActionCollection*>(entry.get()))
      {
        compose(*actions);
        continue;
      }
      if (const auto action = std::dynamic_pointer_cast<mrpt::obs::CAction>(entry))
      {
        CActionCollection alone;
        alone.insertPtr(action);
        compose(alone);
        continue;
      }
      return stepOf(entry);
    }
    return std::nullopt;
  }

  [[nodiscard]] bool hasActions() const { return hasActions_; }
  [[nodiscard]] const std::optional<std::string>& damage() const { return file_.damage(); }

 private:
  void compose(const CActionCollection& actions)
  {
    const auto movement = movementOf(actions);
    if (!movement) return;
    hasActions_ = true;
    pose_ = pose_ + movement->increment;
    actionTime_ = movement->time;
  }

  Step stepOf(const mrpt::serialization::CSerializable::Ptr& entry)
  {
    Step step;
    step.actionPose_map = pose_;
    if (const auto* frame = dynamic_cast<const CSensoryFrame*>(entry.get()))
      for (const auto& observation : *frame) add(observation, step);
    else if (const auto observation = std::dynamic_pointer_cast<CObservation>(entry))
      add(observation, step);
    else
      step.foreign = LeftOutScan{shortClassName(*entry), "not an observation"};
    step.frameTime = timeOf(step.frame, actionTime_);
    return step;
  }

  static void add(const CObservation::Ptr& observation, Step& step)
  {
    if (!observation) return;
    if (const auto* odometry = dynamic_cast<const CObservationOdometry*>(observation.get()))
      step.odometry.push_back({odometry->timestamp, CPose3D(odometry->odometry)});
    else
      step.frame.push_back(observation);
  }

  RawlogFile file_;
  CPose3D pose_;
  std::optional<Time> actionTime_;
  bool hasActions_ = false;
};

/// What a first walk through a log finds.
struct Survey
{
  bool hasActions = false;
  bool timesGoBackwards = false;  ///< those of the frames
  size_t frames = 0;
  size_t items = 0;
  std::vector<TimedPose> actionPoses;
  std::vector<TimedPose> odometry;
  std::vector<Time> observationTimes;
};

Survey surveyOf(const std::string& path, const std::optional<RawlogFile::Limit>& limit,
                const std::function<bool()>& shouldStop)
{
  Survey survey;
  FrameReader reader(path, limit);
  while (const auto step = reader.next())
  {
    if (shouldStop()) break;
    survey.items += step->frame.size() + (step->foreign ? 1 : 0);
    if (!step->frame.empty()) ++survey.frames;
    for (const TimedPose& pose : step->odometry)
      if (validTime(pose.time)) survey.odometry.push_back(pose);
    for (const auto& observation : step->frame)
      if (validTime(observation->timestamp)) survey.observationTimes.push_back(observation->timestamp);
    if (!step->frameTime) continue;
    const auto& poses = survey.actionPoses;
    if (!poses.empty() && *step->frameTime < poses.back().time) survey.timesGoBackwards = true;
    survey.actionPoses.push_back({*step->frameTime, step->actionPose_map});
  }
  survey.hasActions = reader.hasActions();
  return survey;
}

std::string spanText(Time first, Time last)
{
  return mrpt::format("%.3f to %.3f s", mrpt::Clock::toDouble(first), mrpt::Clock::toDouble(last));
}

/// @throws std::runtime_error if no observation lies within the time that the poses cover.
void requireOverlap(const std::string& path, const Survey& survey, const PoseTrack& track)
{
  const auto& times = survey.observationTimes;
  if (times.empty()) return;
  if (std::any_of(times.begin(), times.end(), [&](Time time) { return track.at(time).has_value(); })) return;
  const auto [first, last] = std::minmax_element(times.begin(), times.end());
  throw std::runtime_error(path + ": none of its " + std::to_string(times.size()) + " observations, at " +
                           spanText(*first, *last) + " since 1970, lies within the time of the poses, " +
                           spanText(track.poses().front().time, track.poses().back().time));
}

class RawlogSource : public ScanSource
{
 public:
  RawlogSource(const std::string& path, std::shared_ptr<const PoseTrack> givenPoses,
               const InputOptions& options)
      : path_(path), limit_(RawlogFile::findLimit(path, options.shouldStop))
  {
    Survey survey = surveyOf(path, limit_, options.shouldStop);
    expectedItems_ = survey.items;
    if (options.shouldStop())
      stand("not read");
    else if (options.standingStill)
      stand("the robot stands at the origin");
    else if (givenPoses)
      follow(std::move(givenPoses), survey, "the given file");
    else if (survey.hasActions)
      followActions(std::move(survey));
    else if (!survey.odometry.empty())
    {
      auto track = std::make_shared<const PoseTrack>(std::move(survey.odometry));
      follow(track, survey, "odometry");
    }
    else if (survey.frames <= 1)
      stand("the log holds no poses; what it holds is taken at the origin");
    else
      throw std::runtime_error(
          path + ": holds " + std::to_string(survey.frames) +
          " observations or frames, but neither actions nor CObservationOdometry to tell "
          "where they were made: give --poses FILE, or --static if the robot stood still");
  }

  [[nodiscard]] const std::string& path() const override { return path_; }
  [[nodiscard]] size_t expectedItems() const override { return expectedItems_; }

  [[nodiscard]] std::optional<ScanItem> next() override
  {
    // Opened with the first scan, not before: it sets MRPT's folder of images.
    if (!reader_) reader_ = std::make_unique<FrameReader>(path_, limit_);
    while (waiting_.empty())
    {
      auto step = reader_->next();
      if (!step) return std::nullopt;
      if (step->foreign) waiting_.emplace_back(*step->foreign);
      for (const auto& observation : step->frame) waiting_.push_back(itemOf(observation, *step));
    }
    ScanItem item = std::move(waiting_.front());
    waiting_.pop_front();
    return item;
  }

  [[nodiscard]] std::vector<std::string> damages() const override
  {
    if (!reader_ || !reader_->damage()) return {};
    return {*reader_->damage()};
  }

  [[nodiscard]] std::vector<std::string> notes() const override
  {
    std::vector<std::string> all{note_};
    if (heldPoses_ > 0)
      all.push_back(std::to_string(heldPoses_) +
                    " observations lie before the first or after the last pose and took that of their frame");
    return all;
  }

 private:
  enum class Poses
  {
    Standing,
    Actions,
    Track
  };

  void stand(const std::string& note)
  {
    kind_ = Poses::Standing;
    note_ = note;
  }

  void follow(std::shared_ptr<const PoseTrack> track, const Survey& survey, const std::string& origin)
  {
    requireOverlap(path_, survey, *track);
    kind_ = Poses::Track;
    track_ = std::move(track);
    note_ = std::to_string(track_->poses().size()) + " poses from " + origin;
  }

  void followActions(Survey survey)
  {
    kind_ = Poses::Actions;
    note_ = "poses from the log's actions";
    if (survey.timesGoBackwards)
      note_ += "; its time stamps go backwards: every observation takes the pose of its frame";
    else
      track_ = std::make_shared<const PoseTrack>(std::move(survey.actionPoses));
  }

  ScanItem itemOf(const CObservation::Ptr& observation, const FrameReader::Step& step)
  {
    const auto time = validTime(observation->timestamp);
    if (kind_ == Poses::Standing) return ObservedScan{observation, CPose3D()};
    if (kind_ == Poses::Actions) return ObservedScan{observation, poseFromActions(time, step)};
    if (!time) return LeftOutScan{shortClassName(*observation), "it has no time stamp"};
    const auto pose = track_->at(*time);
    if (!pose)
      return LeftOutScan{shortClassName(*observation), "it lies before the first or after the last pose"};
    return ObservedScan{observation, *pose};
  }

  CPose3D poseFromActions(std::optional<Time> time, const FrameReader::Step& step)
  {
    if (!track_ || !time || time == step.frameTime) return step.actionPose_map;
    const auto pose = track_->at(*time);
    if (!pose) ++heldPoses_;
    return pose.value_or(step.actionPose_map);
  }

  std::string path_;
  std::optional<RawlogFile::Limit> limit_;
  size_t expectedItems_ = 0;
  Poses kind_ = Poses::Standing;
  std::shared_ptr<const PoseTrack> track_;
  std::string note_;
  std::unique_ptr<FrameReader> reader_;
  std::deque<ScanItem> waiting_;
  size_t heldPoses_ = 0;
};
}  // namespace

std::unique_ptr<ScanSource> openRawlogSource(const std::string& path,
                                             std::shared_ptr<const PoseTrack> givenPoses,
                                             const InputOptions& options)
{
  return std::make_unique<RawlogSource>(path, std::move(givenPoses), options);
}

}  // namespace lamap::tools
