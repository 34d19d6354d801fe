#include "text_table.h"

#include <mrpt/core/format.h>

#include <algorithm>
#include <ostream>

namespace lamap::tools
{
void TextTable::print(std::ostream& out) const
{
  if (rows_.empty()) return;
  std::vector<size_t> widths(rows_.front().size());
  for (const auto& row : rows_)
    for (size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  for (const auto& row : rows_)
  {
    for (size_t i = 0; i < row.size(); ++i)
    {
      const std::string gap(widths[i] - row[i].size(), ' ');
      out << "  " << (i == 0 ? row[i] + gap : gap + row[i]);
    }
    out << "\n";
  }
}

std::string numberText(const std::optional<double>& number)
{
  return number ? mrpt::format("%.4f", *number) : "-";
}

}  // namespace lamap::tools
