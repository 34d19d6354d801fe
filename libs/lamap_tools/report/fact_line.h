#pragma once

#include <iosfwd>
#include <string>

namespace lamap::tools
{
/// A line of a report: a fact's name, what it is, and its unit, aligned with the other lines.
void printFact(std::ostream& out, const std::string& name, const std::string& text,
               const std::string& unit = "");

}  // namespace lamap::tools
