#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <map>
#include <string>

namespace lamap::app
{
/// Turns words into numbers; the words' case counts nothing.
[[nodiscard]] CLI::Validator wordToNumber(std::map<std::string, int> words);

/// For an option of an enumeration's type: one of the words that name its values.
template <typename Enumeration>
[[nodiscard]] CLI::Validator oneOf(const std::map<std::string, Enumeration>& words)
{
  std::map<std::string, int> numbers;
  for (const auto& [word, value] : words) numbers.emplace(word, static_cast<int>(value));
  return wordToNumber(std::move(numbers));
}

/// A whole number between limits that are legal themselves.
[[nodiscard]] CLI::Validator wholeNumber(int64_t low, int64_t high);

/// A number from 0 to 1.
[[nodiscard]] CLI::Validator probability();

/// More threads than any machine has today are a mistake.
constexpr int64_t kMostThreads = 1024;

}  // namespace lamap::app
