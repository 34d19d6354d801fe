#include "display.h"

#include <mrpt/img/CImage.h>

#include <algorithm>
#include <map>
#include <sstream>
#include <stdexcept>
#include <thread>

namespace lamap::test
{
namespace
{
constexpr std::chrono::seconds kPatience(60);

/// The last line of a text.
std::string lastLine(const std::string& text)
{
  std::string last;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);)
    if (!line.empty()) last = line;
  return last;
}
}  // namespace

Display::Display(const std::filesystem::path& folder) : folder_(folder / "display")
{
  std::filesystem::create_directories(folder_ / "home");
  // Xvfb chooses a free display number and prints it.
  server_ = std::make_unique<Program>(
      std::vector<std::string>{"Xvfb", "-displayfd", "1", "-screen", "0", "1280x900x24", "-nolisten", "tcp"},
      folder_);
  const auto printedNumber = [this]
  {
    const std::string printed = lastLine(server_->output());
    return !printed.empty() && std::all_of(printed.begin(), printed.end(), ::isdigit);
  };
  if (!becomes(printedNumber, kPatience))
    throw std::runtime_error("Xvfb does not start: " + server_->output());
  name_ = ":" + lastLine(server_->output());
}

Program::Environment Display::environment() const
{
  return {{"DISPLAY", name_},
          {"HOME", (folder_ / "home").string()},
          {"LIBGL_ALWAYS_SOFTWARE", "1"},
          {"LC_ALL", "C"}};
}

std::string Display::tool(const std::vector<std::string>& command) const
{
  const Outcome outcome = run(command, folder_, kPatience, environment());
  return outcome.succeeded() ? outcome.output : "";
}

std::string Display::windowId(const std::string& title) const
{
  return lastLine(tool({"xdotool", "search", "--onlyvisible", "--name", title}));
}

bool Display::hasWindow(const std::string& title) const
{
  return !windowId(title).empty();
}

void Display::focus(const std::string& title) const
{
  if (!becomes([&] { return hasWindow(title); }, kPatience))
    throw std::runtime_error("no window has '" + title + "' in its title");
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  tool({"xdotool", "windowfocus", "--sync", windowId(title)});
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
}

void Display::resize(const std::string& title, int width, int height) const
{
  tool({"xdotool", "windowmove", windowId(title), "0", "0"});
  tool({"xdotool", "windowsize", "--sync", windowId(title), std::to_string(width), std::to_string(height)});
}

void Display::click(const std::string& title, double x, double y) const
{
  const std::string window = windowId(title);
  std::istringstream lines(tool({"xdotool", "getwindowgeometry", "--shell", window}));
  std::map<std::string, int> is;
  for (std::string line; std::getline(lines, line);)
    if (const size_t equals = line.find('='); equals != std::string::npos)
      is[line.substr(0, equals)] = std::atoi(line.c_str() + equals + 1);
  tool({"xdotool", "mousemove", std::to_string(static_cast<int>(is["X"] + x * is["WIDTH"])),
        std::to_string(static_cast<int>(is["Y"] + y * is["HEIGHT"])), "click", "1"});
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
}

void Display::press(const std::vector<std::string>& keys) const
{
  for (const std::string& key : keys)
  {
    tool({"xdotool", "key", key});
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
  }
}

void Display::type(const std::string& text) const
{
  std::string keys = text;
  std::replace(keys.begin(), keys.end(), '\n', '\r');
  tool({"xdotool", "type", "--delay", "8", keys});
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
}

Display::Picture Display::screenshot(const std::filesystem::path& png) const
{
  tool({"import", "-window", "root", png.string()});
  mrpt::img::CImage image;
  if (!image.loadFromFile(png.string()))
    throw std::runtime_error("no picture of the display: " + png.string());
  constexpr int kClearly = 40;  // of 255
  Picture picture;
  for (unsigned y = 0; y < image.getHeight(); ++y)
    for (unsigned x = 0; x < image.getWidth(); ++x)
    {
      const unsigned char* bgr = image.ptr<unsigned char>(x, y);
      const auto [least, most] = std::minmax({bgr[0], bgr[1], bgr[2]});
      picture.coloured += most - least > kClearly;
      picture.green += bgr[1] > bgr[0] + kClearly && bgr[1] > bgr[2] + kClearly;
    }
  const double pixels = static_cast<double>(image.getWidth()) * static_cast<double>(image.getHeight());
  picture.coloured /= pixels;
  picture.green /= pixels;
  return picture;
}

}  // namespace lamap::test
