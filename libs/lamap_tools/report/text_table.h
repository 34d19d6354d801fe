#pragma once

#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

namespace lamap::tools
{
/// Columns as wide as their widest text, the first left-aligned, the others right-aligned.
class TextTable
{
 public:
  /// The last column holds sentences: it is left-aligned.
  void endWithSentences() { endsWithSentences_ = true; }
  [[nodiscard]] bool isLeftAligned(size_t column) const
  {
    return column == 0 || (endsWithSentences_ && column + 1 == rows_.front().size());
  }
  /// Adds a row with as many texts as all others.
  void add(std::vector<std::string> row) { rows_.push_back(std::move(row)); }
  [[nodiscard]] const std::vector<std::vector<std::string>>& rows() const { return rows_; }

  void print(std::ostream& out) const;

 private:
  std::vector<std::vector<std::string>> rows_;
  bool endsWithSentences_ = false;
};

/// A table in Markdown, the first column left-aligned, the others right-aligned.
[[nodiscard]] std::string markdownOf(const TextTable& table);
/// A table as CSV.
[[nodiscard]] std::string csvOf(const TextTable& table);
/// A text as a field of a CSV line, quoted if necessary.
[[nodiscard]] std::string csvField(const std::string& text);

/// Four digits after the point; "-" if empty.
[[nodiscard]] std::string numberText(const std::optional<double>& number);
/// "12.3 %" for 0.123; "-" if empty.
[[nodiscard]] std::string percentText(const std::optional<double>& share);
/// "12.34" for 0.1234 m; "-" if empty.
[[nodiscard]] std::string centimetreText(const std::optional<double>& length_m);

}  // namespace lamap::tools
