#pragma once

#include <lamap_core/scan/scan.h>

#include <cstdint>
#include <fstream>
#include <optional>
#include <string>

namespace lamap::tools
{
/** Reads the scans of OctoMap's binary scan graphs (`.graph`) one after the other. The edges between them are
 * not read. */
class GraphFile
{
 public:
  /// @throws std::runtime_error naming the file if it cannot be opened or is too short for a graph.
  explicit GraphFile(const std::string& path);

  /// Scans that the file states.
  [[nodiscard]] size_t size() const { return size_; }

  /// The next scan; nothing after the last one that can be read.
  [[nodiscard]] std::optional<Scan> next();

  /// What is wrong with the rest of the file, once next() has met it.
  [[nodiscard]] const std::optional<std::string>& damage() const { return damage_; }

 private:
  std::ifstream file_;
  uint64_t fileSize_ = 0;
  size_t size_ = 0;
  size_t read_ = 0;
  std::optional<std::string> damage_;
};

}  // namespace lamap::tools
