#pragma once

#include <lamap_mrpt/learned_map/CLearnedMap.h>

#include <exception>
#include <memory>
#include <vector>

// What every map must stand, wherever it comes from.
namespace lamap::fuzz
{
/// Ends the program: the fuzzer keeps the input.
[[noreturn]] void breakPromise(const char* promise);

/// What may be refused for good reasons: a scan too long for the cells, a sum that would overflow.
/// @return whether it was done
template <typename Change>
bool tryTo(Change&& change)
{
  try
  {
    change();
    return true;
  }
  catch (const std::exception&)
  {
    return false;
  }
}

/// No threads, no words.
void quieten(CLearnedMap& map);

/// The map of these bytes. @throws as MRPT and the map do
[[nodiscard]] std::shared_ptr<CLearnedMap> mapFrom(const std::vector<uint8_t>& bytes);

/// Saved and loaded again, it must have the same bytes.
void requireSaves(const CLearnedMap& map);

/// Asks for everything that a map answers; of a large map, for part of it.
void ask(const CLearnedMap& map);

/// Changes it in every way.
void change(CLearnedMap& map);

}  // namespace lamap::fuzz
