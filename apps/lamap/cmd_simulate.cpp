#include <lamap_tools/simulate/simulate.h>

#include <limits>

#include "command_line.h"

namespace lamap::app
{
namespace
{
constexpr double kDegree = 3.14159265358979323846 / 180;

struct SimulateArguments
{
  tools::SimulateOptions options;
  double angleNoise_deg = 0;
  std::vector<double> poseNoise;  ///< m and degrees
};

int simulate(SimulateArguments& arguments)
{
  tools::SimulateOptions& options = arguments.options;
  options.noise.angle_rad = arguments.angleNoise_deg * kDegree;
  if (!arguments.poseNoise.empty())
  {
    options.noise.position_m = arguments.poseNoise.at(0);
    options.noise.turn_rad = arguments.poseNoise.at(1) * kDegree;
  }
  catchStopSignals();
  options.shouldStop = stopRequested;
  tools::SimulateReport report;
  {
    std::string input;  // of the bar that is shown
    std::unique_ptr<tools::ProgressBar> bar;
    const auto show = [&](const tools::Progress& progress)
    {
      if (!bar || progress.input != input)
      {
        bar.reset();
        input = progress.input;
        bar.reset(new tools::ProgressBar(makeProgressBar(input == options.outPath ? "scan" : "cell")));
      }
      bar->show(progress);
    };
    report = tools::simulate(options, show);
  }
  if (report.stopped) return stoppedByUser("; nothing is written");
  tools::printReport(report, options, results());
  return 0;
}

void describeNoise(CLI::App& command, SimulateArguments& arguments)
{
  tools::SimulateOptions& options = arguments.options;
  const auto add = [&](const char* flag, double& number, const char* what)
  { command.add_option(flag, number, what)->group("Noise (standard deviations; default none)"); };
  add("--range-noise", options.noise.range_m, "Of each range [m]");
  add("--angle-noise", arguments.angleNoise_deg, "Of each ray's direction [deg]");
  add("--point-noise", options.noise.point_m, "Of each coordinate of each point [m] (3D lasers)");
  add("--missing", options.noise.missing, "Share of the returns that get lost, 0 to 1");
  const auto addForMissing = [&](const char* flag, auto& value, const char* what)
  {
    return command.add_option(flag, value, what)
        ->capture_default_str()
        ->group("Noise (standard deviations; default none)");
  };
  addForMissing(
      "--missing-as", options.missingAs,
      "What the log says of a lost return: open (the same as of open space), zero, nan, inf, max or "
      "invalid");
  addForMissing("--missing-burst", options.noise.longestBurst,
                "Lost returns come in bursts of 1 to N neighbouring beams (lasers)");
  add("--odometry-noise", options.odometryNoise,
      "Of each movement in the log, as a share of its length and turn; adds up");
  command.add_option("--pose-noise", arguments.poseNoise, "Of each pose in the log: m,deg; does not add up")
      ->delimiter(',')
      ->expected(2)
      ->group("Noise (standard deviations; default none)");
}

void describe(CLI::App& command, SimulateArguments& arguments)
{
  tools::SimulateOptions& options = arguments.options;
  command
      .add_option("world", options.world,
                  "structured, unstructured, corridor, pier, station, flatland or poles")
      ->required();
  command
      .add_option("-o,--output", options.outPath,
                  "The log, .rawlog or .simplemap; beside it a .tum with the true poses and an .ini for "
                  "lamap build -c")
      ->required();
  command.add_option("--truth", options.truthPaths,
                     "The truth, .csv (x,y,z,label) or .bt (OctoMap); may be given for both");
  command.add_option("--seed", options.seed, "Of the world and of all noise")
      ->check(wholeNumber(0, std::numeric_limits<int64_t>::max()))
      ->capture_default_str();
  command.add_option("--sensor", options.sensor,
                     "sector-laser, pan-tilt-laser, lidar16, planar-laser, sonar or sonar-range; default: "
                     "the world's own");
  command.add_option("--scans", options.scans, "How many (sweeps of a sonar); default: the world's own");
  command.add_option("--max-range", options.rangeMax_m, "Of the sensor [m]; default: its own");
  command.add_option("--trajectory", options.trajectory,
                     "stops, driving, or a file of poses (TUM format), one per scan");
  command.add_option("--at", options.standAt,
                     "x,y,z or x,y,z,yaw [m, deg]: the sensor stands there for all scans");
  command.add_option("--resolution", options.resolution_m, "Edge of the truth's cells [m]")
      ->capture_default_str();
  command.add_option("--truth-depth", options.truthDepth_m,
                     "How deep behind a surface solid cells count [m]; default: one cell");
  command
      .add_option(
          "--truth-of", options.truthOf,
          "solids: cells that are wholly solid or free; surfaces: cells with a surface and free ones, "
          "as far as the sensor could see them")
      ->capture_default_str();
  command.add_option("--surface", options.surfacePath,
                     "Points on all surfaces, .csv (x,y,z), for the distances of lamap eval --surface");
  describeNoise(command, arguments);
}

void check(const CLI::App& command, const SimulateArguments& arguments)
{
  if (arguments.options.truthDepth_m && arguments.options.truthPaths.empty())
    throw CLI::ValidationError("simulate", "--truth-depth needs --truth FILE");
  if (command.count("--truth-of") > 0 && arguments.options.truthPaths.empty())
    throw CLI::ValidationError("simulate", "--truth-of needs --truth FILE");
  for (const char* flag : {"--missing-as", "--missing-burst"})
    if (command.count(flag) > 0 && command.count("--missing") == 0)
      throw CLI::ValidationError("simulate", flag + std::string(" needs --missing SHARE"));
}
}  // namespace

void addSimulate(CLI::App& app, Action& action)
{
  addCommand<SimulateArguments, simulate>(app, action, "simulate",
                                          "Make a world whose truth is known, and a log of a sensor in it",
                                          describe, check);
}

}  // namespace lamap::app
