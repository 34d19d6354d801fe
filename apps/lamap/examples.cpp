#include "commands.h"

#include <string>
#include <utility>
#include <vector>

namespace lamap::app
{
namespace
{
using Lines = std::vector<const char*>;

/** Examples of each command that run as they stand, one command after the other in this order: the first ones
 * make the logs that the others read. */
const std::vector<std::pair<const char*, Lines>>& examples()
{
  static const std::vector<std::pair<const char*, Lines>> all = {
      {"simulate",
       {"lamap simulate structured --truth room.csv -o room.rawlog",
        "lamap simulate corridor --sensor lidar16 --scans 3 --range-noise 0.02 -o corridor.simplemap",
        "lamap simulate pier --scans 1 -o pier.rawlog"}},
      {"build",
       {"lamap build -i room.rawlog -c room.ini -m bgkMap -o room.lamap.gz",
        "lamap build -i corridor.simplemap -m hilbertMap -s creationOpts.resolution=0.2 -o corridor.lamap.gz",
        "lamap build -i pier.rawlog -c pier.ini -m bgkMap -s insertOpts.beamWidth=observation -o "
        "pier.lamap.gz"}},
      {"info",
       {"lamap info room.lamap.gz", "lamap info --json room.lamap.gz",
        "lamap info room.rawlog  # sensors, ranges and poses of a log: before the first build"}},
      {"query",
       {"lamap query room.lamap.gz --at 1,0.5,0.3 --at -1,0,0.3",
        "lamap query room.lamap.gz --points room.csv > answers.csv"}},
      {"eval",
       {"lamap eval room.lamap.gz --truth room.csv",
        "lamap eval --held-out 4 -i room.rawlog -m bgkMap  # without a truth"}},
      {"compare",
       {"lamap compare -i room.rawlog --truth room.csv -m bgkMap -m octoMap",
        "lamap compare -i room.rawlog --held-out 4 -m bgkMap -m 'wider: bgkMap insertOpts.kernelSupport=0.3' "
        "-o room.html"}},
      {"export",
       {"lamap export room.lamap.gz -o room.ply",
        "lamap export room.lamap.gz --states occupied,free -o cells.csv",
        "lamap export room.lamap.gz --z-min 0.2 --z-max 1.5 -o room.yaml  # for map_server of ROS",
        "lamap export room.lamap.gz --z-min 0.2 --z-max 1.5 -o room.gridmap.gz  # MRPT's own grid"}},
      {"render",
       {"lamap render room.lamap.gz --z-max 2 -o above.png",
        "lamap render room.lamap.gz --view slice --z 1 -o slice.png",
        "lamap render room.lamap.gz --view 3d --z-max 2 --azimuth -30 -o room3d.png"}},
      {"thin",
       {"lamap thin -i room.rawlog --keep-every 30 -o sparse.rawlog",
        "lamap thin -i room.rawlog --every 2 -o half.rawlog"}},
      {"tune",
       {"lamap tune -i room.rawlog --held-out 4 -m bgkMap -s insertOpts.kernelSupport=0.15,0.2,0.3 -o "
        "best.ini"}},
      {"run", {"lamap run -- rawlog-edit --info -i room.rawlog"}},
      {"completion", {"lamap completion bash > lamap.bash", "lamap completion zsh > _lamap"}},
  };
  return all;
}
}  // namespace

void addExamples(CLI::App& app)
{
  for (const auto& [name, lines] : examples())
  {
    CLI::App* const command = app.get_subcommand(name);
    std::string text = command->get_footer();
    if (!text.empty()) text += "\n\n";
    text += "Examples:";
    for (const char* line : lines) text += std::string("\n  ") + line;
    command->footer(text);
  }
  app.footer(
      "A first map:\n"
      "  lamap simulate structured --truth room.csv -o room.rawlog\n"
      "  lamap build -i room.rawlog -c room.ini -m bgkMap -o room.lamap.gz\n"
      "  lamap eval room.lamap.gz --truth room.csv\n"
      "`lamap COMMAND --help` ends with examples of each command.");
}

}  // namespace lamap::app
