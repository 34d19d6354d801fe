// Stock programs with windows, on a display in memory. Each test keeps its screenshots in its folder.
#include <gtest/gtest.h>

#include <iterator>
#include <memory>
#include <regex>
#include <sstream>
#include <stdexcept>
#include <thread>

#include "display.h"
#include "map_checks.h"
#include "program.h"

namespace
{
using namespace lamap::test;
namespace fs = std::filesystem;

const std::string kSena = "2006-01ENE-21-SENA_Telecom Faculty_one_loop_only.rawlog";
const std::string kOffice = "localization_demo.simplemap.gz";
constexpr std::chrono::seconds kPatience(60);

/// An .ini file without its comments, which may contain letters that no key types.
std::string withoutComments(const std::string& ini)
{
  std::string kept;
  std::istringstream lines(ini);
  for (std::string line; std::getline(lines, line);)
    if (!line.empty() && line.front() != '#') kept += line.substr(0, line.find("//")) + "\n";
  return kept;
}

class EachMapInAWindow : public ::testing::TestWithParam<MapKind>
{
};
FOR_EACH_KIND_OF_MAP(EachMapInAWindow);

void buildOfficeMap(const fs::path& folder)
{
  const Outcome built = run({lamapTool(), "build", "-i", *dataset(kOffice), "-c", configFile("build/bgk.ini"),
                             "-o", "map.lamap.gz"},
                            folder);
  ASSERT_TRUE(built.succeeded()) << built.output;
}

TEST_P(EachMapInAWindow, MatchesScansInMapPartition)
{
  SKIP_WITHOUT_PROGRAM("map-partition");
  SKIP_WITHOUT_DATASET(kOffice);
  SKIP_WITHOUT_DISPLAY();
  const fs::path folder = freshFolder();
  const Display display(folder);  // for the matrices that it shows
  fs::copy_file(configFile("map-partition", GetParam()), folder / "MAP-PARTITION_CONFIG.ini");
  const Outcome outcome = run(withPlugin({"map-partition", *dataset(kOffice)}), folder,
                              std::chrono::seconds(180), display.environment());
  ASSERT_TRUE(outcome.succeeded()) << outcome.output;
  // Our options, as the program prints them after reading.
  for (const std::string option : {"maxRange *= *20 ", "planar *= *true"})
    EXPECT_TRUE(std::regex_search(outcome.output, std::regex(option))) << option << "\n" << outcome.output;

  const fs::path results = folder / "MAP-PARTITION_RESULTS";
  EXPECT_TRUE(fs::exists(results / "out_part#000.simplemap"));
  EXPECT_TRUE(fs::exists(results / "out_part#001.simplemap")) << "only one part\n" << outcome.output;
  // A scan must match its neighbour better than a scan from another room.
  std::istringstream matrix(readFile(results / "matrix_A.txt"));
  std::vector<std::vector<double>> match;
  for (std::string line; std::getline(matrix, line);)
  {
    std::istringstream row(line);
    match.emplace_back(std::istream_iterator<double>(row), std::istream_iterator<double>());
  }
  ASSERT_EQ(match.size(), 72u);
  double near = 0, far = 0;
  for (size_t i = 0; i + 1 < match.size(); ++i)
  {
    ASSERT_EQ(match[i].size(), 72u);
    near += match[i][i + 1];
    far += match[i][(i + 36) % 72];
  }
  EXPECT_GT(near, 30);
  EXPECT_LT(far, near / 2);
}

TEST(SceneViewer, ShowsOurScenesWithoutThePlugin)
{
  SKIP_WITHOUT_PROGRAM("SceneViewer3D");
  SKIP_WITHOUT_DATASET(kOffice);
  SKIP_WITHOUT_DISPLAY();
  const fs::path folder = freshFolder();
  buildOfficeMap(folder);
  const Outcome exported = run({lamapTool(), "export", "map.lamap.gz", "-o", "map.3Dscene"}, folder);
  ASSERT_TRUE(exported.succeeded()) << exported.output;

  const Display display(folder);
  Program viewer({"SceneViewer3D", "map.3Dscene"}, folder, display.environment());
  display.focus("3Dscene");
  display.resize("3Dscene", 1200, 850);
  // Cubes have a colour that nothing else in the window has.
  Display::Picture picture;
  EXPECT_TRUE(becomes(
      [&]
      {
        picture = display.screenshot(folder / "scene_viewer.png");
        return picture.coloured > 0.005;
      },
      kPatience))
      << picture.coloured << " coloured, " << picture.green << " green";
  EXPECT_TRUE(viewer.isRunning());
  const std::string printed = viewer.output();
  EXPECT_EQ(printed.find("xception"), std::string::npos) << printed;
}

/// RawLogViewer with the plug-in and a log, with a large window and the tip of the day closed.
class RawLogViewer
{
 public:
  RawLogViewer(const Display& display, const fs::path& folder, const std::string& log)
  {
    const std::string tip = "Tip of the Day";
    const auto opens = [&]
    {
      program_.reset();
      program_ = std::make_unique<Program>(std::vector<std::string>{"RawLogViewer", "-l", pluginFile(), log},
                                           folder, display.environment());
      return becomes([&] { return display.hasWindow(tip); }, kPatience);
    };
    // On a busy machine it occasionally starts without a window; then it is started again.
    if (!opens() && !opens())
      throw std::runtime_error("RawLogViewer " +
                               std::string(program_->isRunning() ? "opens no window" : "has ended") +
                               "; it printed: " + program_->output());
    display.focus(tip);
    display.press({"Escape"});
    display.focus("RawlogViewer - Part");
    display.resize("RawlogViewer - Part", 1270, 880);
  }

  Program& program() { return *program_; }

 private:
  std::unique_ptr<Program> program_;
};

TEST_P(EachMapInAWindow, IsMadeInTheRawMapDialogOfRawLogViewer)
{
  SKIP_WITHOUT_PROGRAM("RawLogViewer");
  SKIP_WITHOUT_DATASET(kSena);
  SKIP_WITHOUT_DISPLAY();
  const fs::path folder = freshFolder();
  cutLog(*dataset(kSena), 60, folder / "part.rawlog");
  const Display display(folder);
  RawLogViewer viewer(display, folder, "part.rawlog");
  // Each step is repeated if it had no effect: on a busy machine, a key may be too early.
  const std::string dialog = "raw map";
  ASSERT_TRUE(becomes(
      [&]
      {
        // Tools, Open paths and map generation module
        display.press({"Escape", "F10", "Right", "Right", "Right", "Down", "Return"});
        if (!becomes([&] { return display.hasWindow(dialog); }, kPatience / 3)) return false;
        // The dialog of an earlier try, which was slow, is closed by the Escape of this one.
        std::this_thread::sleep_for(std::chrono::seconds(2));
        return display.hasWindow(dialog);
      },
      kPatience));

  // Backwards from the text box with the configuration to a button; the nearest one is Close.
  const auto pressButton = [&](int fromClose)
  {
    display.focus(dialog);
    display.click(dialog, 0.85, 0.3);
    display.press({"ctrl+shift+Tab"});
    for (int i = 0; i < fromClose; ++i) display.press({"shift+Tab"});
    display.press({"space"});
  };
  display.focus(dialog);
  display.click(dialog, 0.85, 0.3);
  display.press({"ctrl+a"});
  display.type(withoutComments(readFile(configFile("rawlogviewer", GetParam()))));
  constexpr int kMapFromOdometry = 3;  // while the buttons of the result are disabled
  pressButton(kMapFromOdometry);

  constexpr std::chrono::seconds kStep(10);
  constexpr int kSaveMapAsText = 5;
  ASSERT_TRUE(becomes(
      [&]
      {
        pressButton(kSaveMapAsText);
        return becomes([&] { return display.hasWindow("Save as text"); }, kStep);
      },
      kPatience));
  // Our files are written first, each as a whole; the points file grows.
  const fs::path saved = folder / ("raw_" + savedName(GetParam()) + ".lamap.gz");
  const fs::path savedPoints = folder / "raw_mrpt__maps__CSimplePointsMap_01.txt";
  ASSERT_TRUE(becomes(
      [&]
      {
        if (display.hasWindow("Save as text"))
        {
          display.focus("Save as text");
          display.press({"ctrl+a"});
          display.type((folder / "raw").string() + "\n");
        }
        return becomes([&] { return fs::exists(savedPoints); }, kStep);
      },
      kPatience))
      << viewer.program().output();
  display.focus(dialog);  // possible again once everything is saved
  const Outcome info = run({lamapTool(), "info", saved.string()}, folder);
  EXPECT_TRUE(std::regex_search(info.output, std::regex("maxRange +30 "))) << "differs from what was typed\n"
                                                                           << info.output;
  // With odometry alone, walls appear twice; Hilbert maps fill the gap between them.
  expectSameWalls(loadSavedMap(saved), readPoints(savedPoints), 0.85);

  constexpr int kPreview = 1;
  pressButton(kPreview);
  display.focus("3D preview");
  std::this_thread::sleep_for(std::chrono::seconds(2));
  const Display::Picture picture = display.screenshot(folder / "raw_map.png");
  EXPECT_GT(picture.green, 0.0002) << "no cubes";
  EXPECT_TRUE(viewer.program().isRunning()) << viewer.program().output();
}

TEST(RawLogViewer, ShowsAMapThatALogHolds)
{
  SKIP_WITHOUT_PROGRAM("RawLogViewer");
  SKIP_WITHOUT_DATASET(kOffice);
  SKIP_WITHOUT_DISPLAY();
  const fs::path folder = freshFolder();
  buildOfficeMap(folder);
  writeLogWithMap(folder / "map.lamap.gz", folder / "with_map.rawlog");
  const Display display(folder);
  RawLogViewer viewer(display, folder, "with_map.rawlog");
  // In the tree, go from a row near the top to the log itself, its first entry, and the map.
  display.click("RawlogViewer - Part", 0.08, 0.12);
  display.press({"Up", "Up", "Up", "Down", "Down"});
  Display::Picture picture;
  EXPECT_TRUE(becomes(
      [&]
      {
        picture = display.screenshot(folder / "map_in_log.png");
        return picture.green > 0.0005;
      },
      std::chrono::seconds(20)))
      << picture.coloured << " coloured, " << picture.green << " green";
  EXPECT_TRUE(viewer.program().isRunning()) << viewer.program().output();
}

}  // namespace
