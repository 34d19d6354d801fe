#pragma once

#include <string>

namespace lamap::tools
{
/// The extension in lower case, with its dot; empty if there is none.
[[nodiscard]] std::string extensionOf(const std::string& path);

/// Whether a path ends so and has something before it, ignoring case. @param ending  in lower case
[[nodiscard]] bool endsWith(const std::string& path, const std::string& ending);

}  // namespace lamap::tools
