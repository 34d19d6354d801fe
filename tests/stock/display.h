#pragma once

#include "program.h"

#include <filesystem>
#include <memory>
#include <string>

namespace lamap::test
{
/** An X display in memory, for programs with windows. There is no window manager: windows overlap in the
 * upper left corner, and none has the focus unless it is set. */
class Display
{
 public:
  /// @throws std::runtime_error if Xvfb does not start
  explicit Display(const std::filesystem::path& folder);

  /// Environment variables by which a program finds the display, and its own home folder.
  [[nodiscard]] Program::Environment environment() const;

  /// Whether any window's title contains this text.
  [[nodiscard]] bool hasWindow(const std::string& title) const;
  /// Waits for a window and gives it the focus. @throws std::runtime_error if it does not appear
  void focus(const std::string& title) const;
  /// Also moves it to the upper left corner.
  void resize(const std::string& title, int width, int height) const;
  /// Clicks at a position given as fractions of a window's width and height.
  void click(const std::string& title, double x, double y) const;
  /// Presses keys one after the other, as xdotool names them.
  void press(const std::vector<std::string>& keys) const;
  /// Types text; line ends become presses of Return.
  void type(const std::string& text) const;

  /// Contents of a picture, as shares of its pixels.
  struct Picture
  {
    double coloured = 0;  ///< neither grey, white nor black
    double green = 0;     ///< clearly greener than red and than blue
  };
  /// A screenshot of the whole display, also kept as a file for inspection.
  Picture screenshot(const std::filesystem::path& png) const;

 private:
  std::string tool(const std::vector<std::string>& command) const;
  std::string windowId(const std::string& title) const;

  std::filesystem::path folder_;
  std::string name_;
  std::unique_ptr<Program> server_;
};

#define SKIP_WITHOUT_DISPLAY() \
  for (const char* tool : {"Xvfb", "xdotool", "import"}) SKIP_WITHOUT_PROGRAM(tool)

}  // namespace lamap::test
