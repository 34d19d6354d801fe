#include <lamap_tools/report/text_table.h>

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
    std::string line;
    for (size_t i = 0; i < row.size(); ++i)
    {
      const std::string gap(widths[i] - row[i].size(), ' ');
      line += "  " + (isLeftAligned(i) ? row[i] + gap : gap + row[i]);
    }
    if (endsWithSentences_) line.erase(line.find_last_not_of(' ') + 1);
    out << line << "\n";
  }
}

std::string markdownOf(const TextTable& table)
{
  std::string text;
  for (const auto& row : table.rows())
  {
    for (const std::string& field : row)
    {
      text += "| ";
      for (const char c : field) text += c == '|' ? "\\|" : std::string(1, c);
      text += " ";
    }
    text += "|\n";
    if (&row != &table.rows().front()) continue;
    for (size_t i = 0; i < row.size(); ++i) text += table.isLeftAligned(i) ? "|---" : "|---:";
    text += "|\n";
  }
  return text;
}

std::string csvOf(const TextTable& table)
{
  std::string text;
  for (const auto& row : table.rows())
  {
    for (size_t i = 0; i < row.size(); ++i) text += (i > 0 ? "," : "") + csvField(row[i]);
    text += "\n";
  }
  return text;
}

std::string csvField(const std::string& text)
{
  if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + "\"";
}

std::string numberText(const std::optional<double>& number)
{
  return number ? mrpt::format("%.4f", *number) : "-";
}

std::string percentText(const std::optional<double>& share)
{
  return share ? mrpt::format("%.1f %%", 100 * *share) : "-";
}

std::string centimetreText(const std::optional<double>& length_m)
{
  return length_m ? mrpt::format("%.2f", 100 * *length_m) : "-";
}

}  // namespace lamap::tools
