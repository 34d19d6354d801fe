#include <lamap_tools/inputs/rawlog_source.h>

#include <lamap_mrpt/files/byte_stream.h>
#include <lamap_tools/inputs/rawlog_file.h>
#include <lamap_tools/report/counted.h>
#include <mrpt/core/format.h>
#include <mrpt/math/TPose2D.h>
#include <mrpt/obs/CActionCollection.h>
#include <mrpt/obs/CActionRobotMovement2D.h>
#include <mrpt/obs/CActionRobotMovement3D.h>
#include <mrpt/obs/CObservationOdometry.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/poses/CPose2D.h>

#include <algorithm>
#include <deque>
#include <sstream>
#include <stdexcept>
#include <type_traits>

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

int64_t ticksOf(Time time)
{
  return time.time_since_epoch().count();
}

Time timeFrom(int64_t ticks)
{
  return Time(Time::duration(ticks));
}

/// The movement of an action collection: the 3D one if there is one, else the 2D one with the smallest
/// covariance.
struct Movement
{
  CPose3D increment;
  std::optional<Time> time;
  bool isOdometry = true;
};

std::optional<Movement> movementOf(const CActionCollection& actions)
{
  if (const auto move3D = actions.getActionByClass<mrpt::obs::CActionRobotMovement3D>())
    return Movement{move3D->poseChange.mean, validTime(move3D->timestamp)};
  if (const auto move2D = actions.getBestMovementEstimation())
    return Movement{CPose3D(move2D->poseChange->getMeanVal()), validTime(move2D->timestamp),
                    move2D->estimationMethod != mrpt::obs::CActionRobotMovement2D::emScan2DMatching};
  return std::nullopt;
}

using Frame = std::vector<CObservation::Ptr>;

/// A reading of the odometry, absolute.
struct Odometry
{
  Time time;
  mrpt::math::TPose2D pose;
};

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
  /// @param file  must outlive this
  explicit FrameReader(RawlogFile& file) : file_(file) {}

  struct Step
  {
    Frame frame;  ///< observations but odometry
    std::vector<Odometry> odometry;
    std::optional<LeftOutScan> foreign;
    CPose3D actionPose_map;  ///< the actions so far, composed
    std::optional<Time> frameTime;
    /// Whether icp-slam makes a step of it: a frame after an action, or any single observation; and when.
    bool isStep = false;
    std::optional<Time> stepTime;
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
  /// Whether one of them is, and not the result of matching scans.
  [[nodiscard]] bool actionsAreOdometry() const { return actionsAreOdometry_; }

 private:
  void compose(const CActionCollection& actions)
  {
    const auto movement = movementOf(actions);
    if (!movement) return;
    hasActions_ = true;
    actionsAreOdometry_ = actionsAreOdometry_ || movement->isOdometry;
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
      step.foreign = LeftOutScan{shortClassName(*entry), "not an observation", nullptr};
    step.frameTime = timeOf(step.frame, actionTime_);
    const auto* single = dynamic_cast<const CObservation*>(entry.get());
    step.isStep = single || (hasActions_ && !step.foreign);
    step.stepTime = single ? validTime(single->timestamp) : step.frameTime;
    return step;
  }

  static void add(const CObservation::Ptr& observation, Step& step)
  {
    if (!observation) return;
    if (const auto* odometry = dynamic_cast<const CObservationOdometry*>(observation.get()))
      step.odometry.push_back({odometry->timestamp, odometry->odometry.asTPose()});
    else
      step.frame.push_back(observation);
  }

  RawlogFile& file_;
  CPose3D pose_;
  std::optional<Time> actionTime_;
  bool hasActions_ = false;
  bool actionsAreOdometry_ = false;
};

/** What a first walk through a log finds, in plain numbers: it comes from another process. Times are ticks of
 * MRPT's clock. */
struct Survey
{
  bool hasActions = false;
  bool actionsAreOdometry = false;
  bool timesGoBackwards = false;  ///< those of the frames
  uint64_t frames = 0;
  uint64_t items = 0;
  std::vector<int64_t> frameTimes;
  std::vector<double>
      framePoses;  ///< composed from actions: 16 numbers for each frame's time, column by column
  uint64_t untimedOdometry = 0;  ///< readings without a valid time
  std::vector<int64_t> odometryTimes;
  std::vector<double> odometryPoses;  ///< x, y, phi for each of these
  std::vector<int64_t> observationTimes;
  std::vector<int64_t> stepTimes;  ///< see FrameReader::Step
  std::vector<char> sensors;       ///< their names, each with a line break behind it

  /// Calls visit for each member in the same order, whatever it does with them.
  template <class Self, class Visitor>
  static void visitMembers(Self& self, const Visitor& visit)
  {
    visit(self.hasActions), visit(self.actionsAreOdometry), visit(self.timesGoBackwards);
    visit(self.stepTimes), visit(self.frames), visit(self.items);
    visit(self.frameTimes), visit(self.framePoses);
    visit(self.untimedOdometry), visit(self.odometryTimes), visit(self.odometryPoses);
    visit(self.observationTimes), visit(self.sensors);
  }

  [[nodiscard]] LogContents contents() const
  {
    LogContents contents;
    std::istringstream names(std::string(sensors.begin(), sensors.end()));
    for (std::string name; std::getline(names, name);) contents.sensors.insert(name);
    if (!observationTimes.empty())
      contents.firstTime = timeFrom(*std::min_element(observationTimes.begin(), observationTimes.end()));
    return contents;
  }
  [[nodiscard]] std::vector<TimedPose> posesOfFrames() const
  {
    std::vector<TimedPose> poses;
    mrpt::math::CMatrixDouble44 matrix;
    for (size_t i = 0; i < frameTimes.size(); ++i)
    {
      std::copy_n(&framePoses[16 * i], 16, matrix.data());
      poses.push_back({timeFrom(frameTimes[i]), CPose3D(matrix)});
    }
    return poses;
  }
  [[nodiscard]] std::vector<TimedPose> posesOfOdometry() const
  {
    std::vector<TimedPose> poses;
    for (size_t i = 0; i < odometryTimes.size(); ++i)
    {
      const double* pose = &odometryPoses[3 * i];
      poses.push_back({timeFrom(odometryTimes[i]), CPose3D(mrpt::poses::CPose2D(pose[0], pose[1], pose[2]))});
    }
    return poses;
  }
};

/// Reads a log to its end. @return a survey's members
std::vector<uint8_t> surveyOf(RawlogFile& file)
{
  Survey survey;
  LogContents contents;
  FrameReader reader(file);
  while (const auto step = reader.next())
  {
    survey.items += step->frame.size() + (step->foreign ? 1 : 0);
    if (!step->frame.empty()) ++survey.frames;
    if (step->isStep) survey.stepTimes.push_back(ticksOf(step->stepTime.value_or(INVALID_TIMESTAMP)));
    for (const auto& [time, pose] : step->odometry)
    {
      if (!validTime(time))
      {
        ++survey.untimedOdometry;
        continue;
      }
      survey.odometryTimes.push_back(ticksOf(time));
      survey.odometryPoses.insert(survey.odometryPoses.end(), {pose.x, pose.y, pose.phi});
    }
    for (const auto& observation : step->frame)
    {
      contents.include(*observation);
      if (validTime(observation->timestamp))
        survey.observationTimes.push_back(ticksOf(observation->timestamp));
    }
    if (!step->frameTime) continue;
    auto& times = survey.frameTimes;
    times.push_back(ticksOf(*step->frameTime));
    if (times.size() > 1 && times.back() < times[times.size() - 2]) survey.timesGoBackwards = true;
    const auto matrix = step->actionPose_map.getHomogeneousMatrixVal<mrpt::math::CMatrixDouble44>();
    survey.framePoses.insert(survey.framePoses.end(), matrix.data(), matrix.data() + 16);
  }
  survey.hasActions = reader.hasActions();
  survey.actionsAreOdometry = reader.actionsAreOdometry();
  for (const std::string& name : contents.sensors)
  {
    survey.sensors.insert(survey.sensors.end(), name.begin(), name.end());
    survey.sensors.push_back('\n');
  }

  ByteWriter out;
  Survey::visitMembers(survey,
                       [&out](const auto& member)
                       {
                         if constexpr (std::is_arithmetic_v<std::decay_t<decltype(member)>>)
                           out.number(member);
                         else
                           out.vector(member);
                       });
  return out.take();
}

Survey surveyFrom(const std::vector<uint8_t>& bytes)
{
  Survey survey;
  ByteReader in(bytes);
  Survey::visitMembers(survey,
                       [&in](auto& member)
                       {
                         using Member = std::decay_t<decltype(member)>;
                         if constexpr (std::is_arithmetic_v<Member>)
                           member = in.number<Member>();
                         else
                           member = in.vector<typename Member::value_type>();
                       });
  return survey;
}

std::string spanText(Time first, Time last)
{
  return mrpt::format("%.3f to %.3f s", mrpt::Clock::toDouble(first), mrpt::Clock::toDouble(last));
}

/// Whether an observation lies within the time that the poses cover.
bool overlaps(const Survey& survey, const PoseTrack& track)
{
  return std::any_of(survey.observationTimes.begin(), survey.observationTimes.end(),
                     [&](int64_t time) { return track.at(timeFrom(time)).has_value(); });
}

/// What to say if no observation lies within the time that the poses cover.
std::optional<std::string> whyNoOverlap(const Survey& survey, const PoseTrack& track)
{
  const auto& times = survey.observationTimes;
  if (times.empty() || overlaps(survey, track)) return std::nullopt;
  const auto [first, last] = std::minmax_element(times.begin(), times.end());
  return "of its " + counted(times.size(), "observation") + ", at " +
         spanText(timeFrom(*first), timeFrom(*last)) +
         " since 1970, none lies within the time of the poses, " +
         spanText(track.poses().front().time, track.poses().back().time);
}

/// Whether the times are 0, 1, 2, …, as in icp-slam's log_estimated_path.txt: numbers of steps.
bool countsSteps(const PoseTrack& track)
{
  double expected = 0;
  return std::all_of(track.poses().begin(), track.poses().end(),
                     [&](const TimedPose& pose) { return mrpt::Clock::toDouble(pose.time) == expected++; });
}

/** The poses of steps at their times.
 * @throws std::runtime_error if the log has another number of steps, or they have no times */
std::vector<TimedPose> posesOfSteps(const std::string& path, const PoseTrack& steps, const Survey& survey)
{
  const auto& times = survey.stepTimes;
  const bool allHaveTimes = std::all_of(times.begin(), times.end(),
                                        [](int64_t time) { return validTime(timeFrom(time)).has_value(); });
  if (steps.poses().size() != times.size() || !allHaveTimes)
    throw std::runtime_error(
        path +
        ": the poses that were given have numbers of steps (0, 1, 2, ...) instead of times, as in icp-slam's "
        "log_estimated_path.txt. That works where there is one for each frame after an action, or for each "
        "observation of a log without frames; here are " +
        counted(steps.poses().size(), "pose") + " and " + counted(times.size(), "such step") +
        ". Build from the .simplemap instead that icp-slam wrote beside that file: "
        "-i _finalmap_.simplemap");
  std::vector<TimedPose> poses = steps.poses();
  for (size_t i = 0; i < poses.size(); ++i) poses[i].time = timeFrom(times[i]);
  return poses;
}

class RawlogSource : public ScanSource
{
 public:
  RawlogSource(const std::string& path, std::shared_ptr<const PoseTrack> givenPoses,
               const InputOptions& options)
      : ScanSource(path), mustOverlap_(givenPoses || !options.evenWithoutPoses)
  {
    const RawlogFile::Trial trial = RawlogFile::tryReading(path, surveyOf, options.shouldStop);
    if (trial.stopped)
    {
      stand("not read");
      return;
    }
    limit_ = trial.limit;
    const Survey survey = surveyFrom(trial.survey);
    expectedItems_ = survey.items;
    contents_ = survey.contents();
    if (options.standingStill)
      stand("the robot stands at the origin");
    else if (givenPoses)
      followGiven(std::move(givenPoses), survey);
    else if (survey.hasActions)
      followActions(survey);
    else if (!survey.odometryTimes.empty())
    {
      follow(std::make_shared<const PoseTrack>(survey.posesOfOdometry()), survey, "odometry");
      posesAreOdometry_ = true;
      if (survey.untimedOdometry > 0)
        notes_.push_back("not used: " + std::to_string(survey.untimedOdometry) +
                         " CObservationOdometry without a valid time stamp");
    }
    else if (survey.frames <= 1)
      stand("the log holds no poses; what it holds is taken at the origin");
    else
      doWithoutPoses(survey, options.evenWithoutPoses);
  }

  [[nodiscard]] std::optional<ScanItem> nextOfAll() override
  {
    // Opened with the first scan, not before: it sets MRPT's folder of images.
    if (!file_)
    {
      file_ = std::make_unique<RawlogFile>(path_, limit_);
      reader_.emplace(*file_);
    }
    while (waiting_.empty())
    {
      auto step = reader_->next();
      if (file_->damage()) damages_ = {*file_->damage()};
      if (!step) return std::nullopt;
      if (step->foreign) waiting_.emplace_back(*step->foreign);
      for (const auto& observation : step->frame) waiting_.push_back(itemOf(observation, *step));
    }
    ScanItem item = std::move(waiting_.front());
    waiting_.pop_front();
    return item;
  }

 private:
  enum class Poses
  {
    None,
    Standing,
    Actions,
    Track
  };

  /// @throws std::runtime_error unless that is allowed
  void doWithoutPoses(const Survey& survey, bool isAllowed)
  {
    const std::string remedy = "give --poses FILE, or --static if the robot stood still";
    const std::string odometry =
        std::to_string(survey.untimedOdometry) +
        " CObservationOdometry, but without a valid time stamp to tell when it was made";
    const bool isUntimed = survey.untimedOdometry > 0;
    if (!isAllowed)
      throw std::runtime_error(
          path_ + ": holds " + std::to_string(survey.frames) + " observations or frames" +
          (isUntimed ? " and " + odometry
                     : ", but neither actions nor CObservationOdometry to tell where they "
                       "were made") +
          ": " + remedy);
    kind_ = Poses::None;
    notes_ = {"none" + (isUntimed ? " (it holds " + odometry + ")" : "") + ": " + remedy};
  }

  void stand(const std::string& note)
  {
    kind_ = Poses::Standing;
    notes_ = {note};
  }

  void follow(std::shared_ptr<const PoseTrack> track, const Survey& survey, const std::string& origin)
  {
    notes_ = {counted(track->poses().size(), "pose") + " from " + origin};
    if (const auto reason = whyNoOverlap(survey, *track))
    {
      if (mustOverlap_) throw std::runtime_error(path_ + ": " + *reason);
      notes_.push_back(*reason);
    }
    kind_ = Poses::Track;
    track_ = std::move(track);
  }

  void followGiven(std::shared_ptr<const PoseTrack> given, const Survey& survey)
  {
    if (!countsSteps(*given) || overlaps(survey, *given))
    {
      follow(std::move(given), survey, "the given file");
      return;
    }
    follow(std::make_shared<const PoseTrack>(posesOfSteps(path_, *given, survey)), survey,
           "the given file, whose first column counts the steps of the log");
  }

  void followActions(const Survey& survey)
  {
    kind_ = Poses::Actions;
    posesAreOdometry_ = survey.actionsAreOdometry;
    notes_ = {"poses from the log's actions"};
    if (survey.timesGoBackwards)
      notes_[0] += "; its time stamps go backwards: every observation takes the pose of its frame";
    else
      track_ = std::make_shared<const PoseTrack>(survey.posesOfFrames());
  }

  ScanItem itemOf(const CObservation::Ptr& observation, const FrameReader::Step& step)
  {
    const auto time = validTime(observation->timestamp);
    if (kind_ == Poses::Standing) return ObservedScan{observation, CPose3D()};
    if (kind_ == Poses::Actions) return ObservedScan{observation, poseFromActions(time, step)};
    const auto leftOut = [&](const char* reason) {
      return LeftOutScan{shortClassName(*observation), reason, observation};
    };
    if (kind_ == Poses::None) return leftOut("the log holds no poses");
    if (!time) return leftOut("it has no time stamp");
    const auto pose = track_->at(*time);
    if (!pose) return leftOut("it lies before the first or after the last pose");
    return ObservedScan{observation, *pose};
  }

  CPose3D poseFromActions(std::optional<Time> time, const FrameReader::Step& step)
  {
    if (!track_ || !time || time == step.frameTime) return step.actionPose_map;
    const auto pose = track_->at(*time);
    if (!pose)
    {
      notes_.resize(2);
      notes_[1] = counted(++heldPoses_, "observation") +
                  " before the first or after the last pose took that of the frame";
    }
    return pose.value_or(step.actionPose_map);
  }

  bool mustOverlap_ = true;
  std::optional<RawlogFile::Limit> limit_;
  Poses kind_ = Poses::Standing;
  std::shared_ptr<const PoseTrack> track_;
  std::unique_ptr<RawlogFile> file_;
  std::optional<FrameReader> reader_;
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
