#include <lamap_tools/report/fact_line.h>

#include <iomanip>
#include <ostream>

namespace lamap::tools
{
void printFact(std::ostream& out, const std::string& name, const std::string& text, const std::string& unit)
{
  constexpr int kNameWidth = 34;
  out << std::left << std::setw(kNameWidth) << name << ' ' << text << (unit.empty() ? "" : " ") << unit
      << '\n';
}

}  // namespace lamap::tools
