#include <lamap_core/options/legal_range.h>
#include <lamap_mrpt/observations/isometry.h>
#include <lamap_tools/inputs/ping_file.h>
#include <lamap_tools/inputs/ping_source.h>
#include <lamap_tools/report/counted.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace lamap::tools
{
namespace
{
constexpr const char* kPing = "sonar ping";

class PingSource : public ScanSource
{
 public:
  PingSource(const std::string& path, std::shared_ptr<const PoseTrack> track, const InputOptions& options)
      : ScanSource(path),
        rules_(options.pings),
        sensorOrigin_(options.sensorOrigin),
        track_(std::move(track)),
        file_(PingFile::read(path, options.pings, options.shouldStop))
  {
    expectedItems_ = file_.pings.size();
    contents_.sensors = {kPing};
    for (const Ping& ping : file_.pings)
      contents_.firstTime = contents_.firstTime ? std::min(*contents_.firstTime, ping.time) : ping.time;
    if (track_ && expectedItems_ > 0) requirePoses(options.posesPath);
    notes_ = {track_                  ? "poses from the given file, by time"
              : options.standingStill ? "the robot stood still at the origin"
                                      : "no poses are given: a build needs --poses"};
    readingNotes_ = {echoesText()};
    if (rules_.beamWidth_deg == 0 && rules_.beamHeight_deg == 0)
      readingNotes_.push_back(
          "no opening angles of the beam are given (--ping-beam): echoes are put on its axis");
  }

  [[nodiscard]] std::optional<ScanItem> nextOfAll() override
  {
    if (next_ == file_.pings.size()) return std::nullopt;
    const Ping& ping = file_.pings[next_++];
    const auto pose = track_ ? track_->at(ping.time) : std::optional(mrpt::poses::CPose3D());
    if (!pose) return LeftOutScan{kPing, "made at a time that the poses do not cover", nullptr};
    PointScan scan{kPing, {}, ping.time};
    scan.scan.sensorPose_map = isometryOf(*pose);
    scan.scan.fans.push_back(fanOf(ping, rules_));
    RayFan& fan = scan.scan.fans.back();
    fan.centre = sensorOrigin_;
    for (Ray& ray : fan.rays)
      if (ray.meaning == RayEnd::Return) ray.end += sensorOrigin_;
    return scan;
  }

 private:
  /// @throws std::runtime_error if no ping has a pose
  void requirePoses(const std::string& posesPath) const
  {
    const auto hasPose = [&](const Ping& ping) { return track_->at(ping.time).has_value(); };
    if (std::any_of(file_.pings.begin(), file_.pings.end(), hasPose)) return;
    const auto seconds = [](mrpt::Clock::time_point time)
    { return fixedText(mrpt::Clock::toDouble(time), 3); };
    throw std::runtime_error(
        path_ + ": its pings begin at " + seconds(file_.pings.front().time) + " s, but the poses of " +
        posesPath + " are from " + seconds(track_->poses().front().time) + " to " +
        seconds(track_->poses().back().time) + " s: none covers a ping; both need the same clock");
  }
  [[nodiscard]] std::string echoesText() const
  {
    size_t echoes = 0;
    size_t silent = 0;
    for (const Ping& ping : file_.pings)
    {
      echoes += ping.echoes.size();
      silent += ping.echoes.empty() ? 1 : 0;
    }
    const EchoRules& rules = file_.rules;
    std::string threshold = roundedText(rules.nearThreshold);
    if (rules.farThreshold != rules.nearThreshold)
      threshold += " near the sensor to " + roundedText(rules.farThreshold) + " at the maximum range";
    return counted(file_.pings.size(), "ping") + ", " + counted(echoes, "echo") + " of at least " +
           threshold + (rules_.threshold ? "" : " (half of the highest intensity)") + "; " +
           counted(silent, "ping") + " without an echo";
  }

  PingRules rules_;
  Eigen::Vector3d sensorOrigin_;
  std::shared_ptr<const PoseTrack> track_;
  PingFile file_;
  size_t next_ = 0;
};
}  // namespace

std::unique_ptr<ScanSource> openPingSource(const std::string& path, std::shared_ptr<const PoseTrack> track,
                                           const InputOptions& options)
{
  return std::make_unique<PingSource>(path, std::move(track), options);
}

}  // namespace lamap::tools
