#pragma once

#include <string>

namespace lamap
{
/** Refuses an illegal option.
 * @throws std::invalid_argument "<name> = <value>: must be <legal>" unless the condition holds. */
void requireLegal(bool condition, const char* name, double value, const std::string& legal);

/// A number in its shortest form, for messages.
[[nodiscard]] std::string shortText(double value);

}  // namespace lamap
