#pragma once

#include <cstdint>
#include <cstring>
#include <limits>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

namespace lamap
{
namespace detail
{
/// What a byte stream holds: numbers whose size is the same everywhere. A bool is stored as one byte, 0 or 1.
template <typename T>
inline constexpr bool isStreamable = std::is_arithmetic_v<T> && !std::is_same_v<T, bool> &&
                                     !std::is_same_v<T, wchar_t> && !std::is_same_v<T, long double>;

/// Bytes of a number in the order least significant first, on any machine.
template <typename T>
inline void toLittleEndian([[maybe_unused]] uint8_t* bytes, [[maybe_unused]] std::size_t count)
{
#if __BYTE_ORDER__ == __ORDER_BIG_ENDIAN__
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t b = 0; b < sizeof(T) / 2; ++b)
      std::swap(bytes[i * sizeof(T) + b], bytes[(i + 1) * sizeof(T) - 1 - b]);
#endif
}
}  // namespace detail

/** Appends numbers and texts to a vector of bytes, least significant byte first: the same bytes on every
 * machine.
 *
 * Read back by ByteReader with the same calls in the same order. Enumerations are to be cast to an integer of
 * fixed size by the caller.
 */
class ByteWriter
{
 public:
  /// Integers, float, double; sizeof(T) bytes.
  template <typename T>
  void number(T number)
  {
    if constexpr (std::is_same_v<T, bool>)
      bytes_.push_back(number ? 1 : 0);
    else
      numbers(&number, 1);
  }

  /// `count` numbers without their count: for a reader that knows it.
  template <typename T>
  void numbers(const T* first, std::size_t count)
  {
    static_assert(detail::isStreamable<T>, "integers, float or double");
    if (count == 0) return;
    const std::size_t before = bytes_.size();
    bytes_.resize(before + count * sizeof(T));
    std::memcpy(bytes_.data() + before, first, count * sizeof(T));
    detail::toLittleEndian<T>(bytes_.data() + before, count);
  }

  /// The count in 8 bytes, then the numbers.
  template <typename T>
  void vector(const std::vector<T>& all)
  {
    number<uint64_t>(all.size());
    numbers(all.data(), all.size());
  }

  /// The length in 4 bytes, then the characters. @throws std::length_error from 2^32 characters on.
  void text(std::string_view characters)
  {
    if (characters.size() > std::numeric_limits<uint32_t>::max())
      throw std::length_error("a text of 4 GiB or more cannot be written");
    number(static_cast<uint32_t>(characters.size()));
    bytes_.insert(bytes_.end(), characters.begin(), characters.end());
  }

  [[nodiscard]] const std::vector<uint8_t>& bytes() const { return bytes_; }
  /// Hands the bytes over; the writer is empty afterwards.
  [[nodiscard]] std::vector<uint8_t> take() { return std::exchange(bytes_, {}); }

 private:
  std::vector<uint8_t> bytes_;
};

/** Reads what ByteWriter wrote. Never reads, and never allocates for, more than the bytes that are there.
 *
 * Every method throws std::runtime_error where the bytes end too early or cannot be what was asked for; the
 * text says at which byte. The bytes must outlive the reader.
 */
class ByteReader
{
 public:
  explicit ByteReader(const std::vector<uint8_t>& bytes) : ByteReader(bytes.data(), bytes.size()) {}
  ByteReader(const uint8_t* first, std::size_t size) : first_(first), size_(size) {}

  template <typename T>
  [[nodiscard]] T number()
  {
    if constexpr (std::is_same_v<T, bool>)
    {
      const auto stored = number<uint8_t>();
      if (stored > 1) fail("a yes or no is " + std::to_string(stored) + ", neither 0 nor 1");
      return stored == 1;
    }
    else
    {
      T read{};
      numbers(&read, 1);
      return read;
    }
  }

  /// Fills `count` numbers whose count is not stored.
  template <typename T>
  void numbers(T* first, std::size_t count)
  {
    static_assert(detail::isStreamable<T>, "integers, float or double");
    if (count == 0) return;
    requireElements(count, sizeof(T));
    std::memcpy(first, first_ + position_, count * sizeof(T));
    detail::toLittleEndian<T>(reinterpret_cast<uint8_t*>(first), count);
    position_ += count * sizeof(T);
  }

  template <typename T>
  [[nodiscard]] std::vector<T> vector()
  {
    const auto count = number<uint64_t>();
    requireElements(count, sizeof(T));
    std::vector<T> all(static_cast<std::size_t>(count));
    numbers(all.data(), all.size());
    return all;
  }

  [[nodiscard]] std::string text()
  {
    const auto length = number<uint32_t>();
    requireElements(length, 1);
    std::string characters(reinterpret_cast<const char*>(first_ + position_), length);
    position_ += length;
    return characters;
  }

  /// For counts that the caller is about to allocate for: throws unless `count` elements of at least
  /// `bytesEach` bytes can still follow.
  void requireElements(uint64_t count, std::size_t bytesEach) const
  {
    if (count > remaining() / bytesEach)
      fail(std::to_string(count) + " x " + std::to_string(bytesEach) + " bytes are due, " +
           std::to_string(remaining()) + " are left");
  }

  /// Throws if bytes are left over: the content is longer than its format.
  void expectEnd() const
  {
    if (remaining() != 0) fail(std::to_string(remaining()) + " bytes are left over");
  }

  [[nodiscard]] std::size_t position() const { return position_; }
  [[nodiscard]] std::size_t remaining() const { return size_ - position_; }

  /// Throws std::runtime_error with the reason and the place: for contents that cannot be.
  [[noreturn]] void fail(const std::string& reason) const
  {
    throw std::runtime_error("at byte " + std::to_string(position_) + " of " + std::to_string(size_) + ": " +
                             reason);
  }

 private:
  const uint8_t* first_;
  std::size_t size_;
  std::size_t position_ = 0;
};

}  // namespace lamap
