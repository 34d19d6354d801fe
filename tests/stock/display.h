#pragma once

#include "program.h"

#include <filesystem>
#include <memory>
#include <string>

namespace lamap::test
{
/** An X display in memory, for programs with windows. There is no window manager: windows lie in the upper
 * left corner over each other, and nothing has the focus unless it is given. */
class Display
{
 public:
  /// @throws std::runtime_error if Xvfb does not start
  explicit Display(const std::filesystem::path& folder);

  /// What a program needs to find it, and a home of its own.
  [[nodiscard]] Program::Environment environment() const;

  /// Whether a window's title has this in it.
  [[nodiscard]] bool hasWindow(const std::string& title) const;
  /// Waits for a window and gives it the focus. @throws std::runtime_error if it does not come
  void focus(const std::string& title) const;
  /// Moves it to the upper left corner, too.
  void resize(const std::string& title, int width, int height) const;
  /// Clicks at a place given as shares of a window's width and height.
  void click(const std::string& title, double x, double y) const;
  /// Presses keys one after the other, as xdotool names them.
  void press(const std::vector<std::string>& keys) const;
  /// Types text; its line ends are presses of Return.
  void type(const std::string& text) const;

  /// What a picture is made of, in shares of its pixels.
  struct Picture
  {
    double coloured = 0;  ///< neither grey, white nor black
    double green = 0;     ///< clearly greener than red and than blue
  };
  /// The whole display, also left as a file for looking at.
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
