#pragma once

#include <string>

namespace lamap::tools
{
/// The extension in small letters, with its point; empty if there is none.
[[nodiscard]] std::string extensionOf(const std::string& path);

/// Whether there is something before this ending. @param ending  in small letters; case counts nothing
[[nodiscard]] bool endsWith(const std::string& path, const std::string& ending);

}  // namespace lamap::tools
