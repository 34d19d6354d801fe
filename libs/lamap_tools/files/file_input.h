#pragma once

#include <fstream>
#include <ios>
#include <string>

namespace lamap::tools
{
/// A file to be read. @param what it should be, for messages: "a truth"
/// @throws std::runtime_error naming the path if it is a folder or cannot be opened, and why
[[nodiscard]] std::ifstream openedFile(const std::string& path, const std::string& what,
                                       std::ios::openmode mode = std::ios::in);

/// @throws std::runtime_error naming the path if it is a folder
void requireNoFolder(const std::string& path, const std::string& what);

}  // namespace lamap::tools
