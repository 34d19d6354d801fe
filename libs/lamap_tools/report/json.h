#pragma once

#include <nlohmann/json.hpp>
#include <optional>

namespace lamap::tools
{
/// Keys keep the order in which they are added.
using Json = nlohmann::ordered_json;

/// null for nothing.
template <class Content>
[[nodiscard]] Json jsonOf(const std::optional<Content>& content)
{
  return content ? Json(*content) : Json(nullptr);
}

}  // namespace lamap::tools
