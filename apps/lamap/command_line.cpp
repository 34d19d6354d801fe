#include "command_line.h"

#include <lamap_tools/files/text_fields.h>

#include <iterator>
#include <sstream>
#include <utility>

namespace lamap::app
{
namespace
{
template <class Number>
CLI::Validator numberFrom(Number low, Number high, const std::string& what)
{
  const auto judge = [=](std::string& text) -> std::string
  {
    // NaN is in no range.
    if (const auto number = tools::numberIn<Number>(text); number && *number >= low && *number <= high)
      return "";
    return "'" + text + "' is not " + what;
  };
  return {judge, ""};
}
}  // namespace

void addMapArgument(CLI::App& command, std::string& map)
{
  command.add_option("map", map, "A saved map (.lamap.gz), or OctoMap's .ot or .bt")->required();
}

std::vector<CLI::Option*> addChoiceOptions(CLI::App& command, ChoiceArguments& arguments,
                                           tools::ScanChoice& choice)
{
  // An unset variable of a script must not choose the whole log.
  const CLI::Validator notEmpty([](const std::string& text)
                                { return text.empty() ? std::string("must not be empty") : std::string(); },
                                "");
  return {command
              .add_option("--sensors", arguments.sensors,
                          "Use only these sensors of the logs: their labels, separated by commas")
              ->check(notEmpty),
          command
              .add_option("--every", choice.every,
                          "Use every Nth observation of each sensor, of those that are chosen otherwise")
              ->check(wholeNumber(1, kMostEvery)),
          command
              .add_option("--from", arguments.from,
                          "Use observations from this time on: seconds from the log's first time stamp, "
                          "seconds since 1970, or a date like 2006-01-21T10:05:07 (UTC)")
              ->check(notEmpty),
          command
              .add_option("--to", arguments.to,
                          "Use observations up to and including this time; a date without a time of day: "
                          "the whole day")
              ->check(notEmpty)};
}

namespace
{
/// Adds the options for `.csv` files that hold pings. @return these options
std::vector<CLI::Option*> addPingOptions(CLI::App& command, LogArguments& arguments, tools::PingRules& rules)
{
  return {
      command.add_option("--ping-beam", arguments.pingBeam,
                         "Of pings in a .csv: opening angles of the beam [degrees], width or width,height"),
      command
          .add_option("--ping-angles", rules.azimuthUnit,
                      "Unit of their azimuths: degrees (default), radians or gradians")
          ->transform(oneOf<tools::AngleUnit>({{"degrees", tools::AngleUnit::Degrees},
                                               {"radians", tools::AngleUnit::Radians},
                                               {"gradians", tools::AngleUnit::Gradians}})),
      command.add_option("--ping-threshold", arguments.pingThreshold,
                         "Least intensity of an echo, or two: near the sensor,at the maximum range; "
                         "default: half of the file's highest"),
      command.add_option("--ping-dead-zone", rules.deadZone_m, "No echo is nearer than this [m]"),
      command.add_option("--ping-separation", rules.separation_m,
                         "Of two echoes nearer to each other than this [m], the stronger counts"),
      command.add_option("--ping-echoes", rules.mostEchoes, "Use this many echoes of a ping, the nearest")
          ->check(wholeNumber(1, kMostEvery))};
}

}  // namespace

std::vector<CLI::Option*> addInputOptions(CLI::App& command, LogArguments& arguments,
                                          tools::InputOptions& inputs)
{
  std::vector<CLI::Option*> options = addChoiceOptions(command, arguments.choice, inputs.choice);
  options.insert(
      options.end(),
      {command.add_option(
           "--poses", inputs.posesPath,
           "Poses to use instead of the log's (TUM or KITTI format, or MRPT's path text); for PCD files, by "
           "the times that their names are, else one per file"),
       command.add_option(
           "--sensor-origin", arguments.sensorOrigin,
           "x,y,z of the sensor in the frame of a PCD file's VIEWPOINT, or of the robot for pings [m]"),
       command
           .add_option(
               "--cloud-frame", inputs.cloudFrame,
               "map or sensor: the frame of the points in PCD files; sensor: the pose turns them into "
               "the map")
           ->transform(oneOf<tools::CloudFrame>(
               {{"map", tools::CloudFrame::Map}, {"sensor", tools::CloudFrame::Sensor}})),
       command.add_flag("--static", inputs.standingStill,
                        "For rawlogs and pings: the robot stood still at the origin"),
       addAllowTruncated(command, arguments.allowTruncated)});
  const std::vector<CLI::Option*> ofPings = addPingOptions(command, arguments, inputs.pings);
  options.insert(options.end(), ofPings.begin(), ofPings.end());
  return options;
}

std::vector<CLI::Option*> addLogOptions(CLI::App& command, LogArguments& arguments,
                                        tools::InputOptions& inputs, unsigned& threads)
{
  constexpr int64_t kMostThreads = 1024;  // more than any machine has: a mistake
  std::vector<CLI::Option*> options = addInputOptions(command, arguments, inputs);
  options.push_back(
      command.add_option("--threads", threads, "Number of threads; 0: as many as the machine has")
          ->check(wholeNumber(0, kMostThreads)));
  return options;
}

CLI::Option* addAllowTruncated(CLI::App& command, bool& allowTruncated)
{
  return command.add_flag("--allow-truncated", allowTruncated, "Exit with 0 even if a log was cut short");
}

void addScoreOptions(CLI::App& command, ScoreArguments& arguments)
{
  command.add_option("--roc", arguments.roc, "Write the ROC curves: .csv or .png");
  command.add_option("--calibration", arguments.calibration,
                     "Write how often cells of each probability are occupied: .csv or .png");
  command
      .add_option("--thresholds", arguments.thresholds,
                  "Probabilities at which precision and recall are given, e.g. 0.5,0.7")
      ->delimiter(',')
      ->check(numberFrom(0.0, 1.0, "a number from 0 to 1"))
      ->capture_default_str();
}

namespace
{
/// Begins the name of a validator that accepts words; they follow.
constexpr const char* kWords = "words";
}  // namespace

CLI::Validator wordToNumber(std::map<std::string, int> words)
{
  std::string name = kWords;
  for (const auto& [word, number] : words) name += " " + word;
  const auto translate = [words = std::move(words)](std::string& text) -> std::string
  {
    std::vector<std::string> all;
    for (const auto& [word, number] : words)
    {
      if (CLI::detail::to_lower(text) == CLI::detail::to_lower(word))
      {
        text = std::to_string(number);
        return "";
      }
      all.push_back(word);
    }
    return "'" + text + "' is none of: " + tools::joined(all);
  };
  return {translate, "", std::move(name)};
}

std::vector<std::string> legalWords(const CLI::Validator& validator)
{
  std::istringstream name(validator.get_name());
  std::string first;
  if (!(name >> first) || first != kWords) return {};
  return {std::istream_iterator<std::string>(name), {}};
}

CLI::Validator wholeNumber(int64_t low, int64_t high)
{
  return numberFrom(low, high, "a whole number from " + std::to_string(low) + " to " + std::to_string(high));
}

CLI::Validator lengthAboveZero()
{
  return numberFrom(1e-6, 1e6, "a length in metres, above 0 and at most 1e6");
}

}  // namespace lamap::app
