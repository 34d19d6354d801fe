#include <lamap_tools/inputs/pcd_file.h>
#include <lamap_tools/report/counted.h>
#include <lzf.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <optional>
#include <sstream>
#include <stdexcept>

namespace lamap::tools
{
namespace
{
struct Field
{
  std::string name;
  size_t size = 4;    ///< bytes of one element
  char type = 'F';    ///< F, I or U
  size_t count = 1;   ///< elements a point
  size_t column = 0;  ///< of its first element in a line
  size_t offset = 0;  ///< of its first byte in a point

  [[nodiscard]] size_t bytes() const { return size * count; }
};

struct Header
{
  std::vector<Field> fields;
  size_t points = 0;
  std::array<double, 7> viewpoint{0, 0, 0, 1, 0, 0, 0};  ///< tx ty tz qw qx qy qz
  Eigen::Vector3d viewpointError = Eigen::Vector3d::Zero();
  std::string data;

  [[nodiscard]] size_t columns() const { return fields.back().column + fields.back().count; }
  [[nodiscard]] size_t stride() const { return fields.back().offset + fields.back().bytes(); }
};

/// Half a unit of a number's last digit, but not more than its sixth digit stands for: "12" may be exact.
double roundingOf(const std::string& word, double number)
{
  const size_t exponentAt = std::min(word.find_first_of("eE"), word.size());
  const size_t pointAt = word.find('.');
  const double decimals = pointAt < exponentAt ? static_cast<double>(exponentAt - pointAt - 1) : 0;
  const double exponent = exponentAt < word.size() ? std::atof(word.c_str() + exponentAt + 1) : 0;
  constexpr double kSixDigits = 5e-6;  // what a stream writes unless told otherwise
  return std::min(0.5 * std::pow(10, exponent - decimals), kSixDigits * std::abs(number));
}

class PcdReader
{
 public:
  explicit PcdReader(const std::string& path) : path_(path), file_(path, std::ios::binary)
  {
    if (!file_ || std::filesystem::is_directory(path)) fail("cannot be read");
    fileSize_ = std::filesystem::file_size(path);
    readHeader();
    selectAxes();
  }

  PcdCloud read()
  {
    PcdCloud cloud;
    const auto& v = header_.viewpoint;
    cloud.viewpoint = {v[0], v[1], v[2]};
    cloud.viewpointError = header_.viewpointError;
    cloud.viewpointRotation = Eigen::Quaterniond(v[3], v[4], v[5], v[6]);
    const bool hasFloats = std::any_of(axes_.begin(), axes_.end(),
                                       [](const Field& axis) { return axis.type == 'F' && axis.size == 4; });
    if (hasFloats) cloud.relativeError = static_cast<double>(std::numeric_limits<float>::epsilon());
    if (header_.data == "ascii")
      readAscii(cloud.points);
    else if (header_.data == "binary")
      readBinary(cloud.points);
    else if (header_.data == "binary_compressed")
      readCompressed(cloud.points);
    else
      fail("DATA is \"" + header_.data + "\"; it must be ascii, binary or binary_compressed");
    cloud.isWhole =
        std::any_of(axes_.begin(), axes_.end(), [](const Field& axis) { return axis.type != 'F'; });
    return cloud;
  }

 private:
  [[noreturn]] void fail(const std::string& what) const { throw std::runtime_error(path_ + ": " + what); }

  template <class Number>
  Number number(std::istream& words, const std::string& key) const
  {
    Number read{};
    if (!(words >> read)) fail("the header's " + key + " lacks a number");
    return read;
  }

  /// A count of the header; refuses signs, which a stream would wrap around.
  size_t countOf(std::istream& words, const std::string& key) const
  {
    const auto read = number<long long>(words, key);
    if (read < 0) fail("the header's " + key + " is negative");
    return static_cast<size_t>(read);
  }

  void readHeader()
  {
    std::optional<size_t> width;
    std::optional<size_t> height;
    std::optional<size_t> points;
    std::string line;
    constexpr int kByteOrderMark[] = {0xEF, 0xBB, 0xBF};
    for (const int letter : kByteOrderMark)
      if (file_.peek() == letter) file_.get();
    constexpr size_t kLongestHeader = 1 << 16;
    while (header_.data.empty())
    {
      if (!readLine(line) || static_cast<size_t>(file_.tellg()) > kLongestHeader)
        fail("not a PCD file: its header has no DATA line");
      std::istringstream words(line);
      std::string key;
      if (!(words >> key) || key[0] == '#') continue;
      if (key == "FIELDS" || key == "COLUMNS")
        for (std::string name; words >> name;) header_.fields.push_back({name});
      else if (key == "SIZE")
        for (Field& field : header_.fields) field.size = countOf(words, key);
      else if (key == "TYPE")
        for (Field& field : header_.fields) field.type = number<char>(words, key);
      else if (key == "COUNT")
        for (Field& field : header_.fields) field.count = countOf(words, key);
      else if (key == "WIDTH")
        width = countOf(words, key);
      else if (key == "HEIGHT")
        height = countOf(words, key);
      else if (key == "POINTS")
        points = countOf(words, key);
      else if (key == "VIEWPOINT")
        readViewpoint(words);
      else if (key == "DATA")
        words >> header_.data;
      else if (key != "VERSION")
        fail("not a PCD file: unknown header line \"" + line.substr(0, 60) + "\"");
    }
    if (header_.fields.empty()) fail("the header has no FIELDS");
    if (!width && !points) fail("the header has neither WIDTH nor POINTS");
    const size_t inGrid = width ? productOf(*width, height.value_or(1)) : *points;
    header_.points = points.value_or(inGrid);
    if (header_.points != inGrid)
      fail("POINTS is " + std::to_string(header_.points) + " but WIDTH x HEIGHT is " +
           std::to_string(inGrid));
    layOut();
  }

  void readViewpoint(std::istream& words)
  {
    for (size_t i = 0; i < header_.viewpoint.size(); ++i)
    {
      std::string word;
      words >> word;
      char* end = nullptr;
      double& part = header_.viewpoint[i];
      part = std::strtod(word.c_str(), &end);
      if (word.empty() || *end != '\0' || !std::isfinite(part))
        fail("the header's VIEWPOINT must have seven numbers, tx ty tz qw qx qy qz; number " +
             std::to_string(i + 1) + (word.empty() ? " is missing" : " is \"" + word + "\""));
      if (i < 3) header_.viewpointError[static_cast<Eigen::Index>(i)] = roundingOf(word, part);
    }
  }

  /// One line without its end. A foreign file has no reason to have lines: they are not read beyond any
  /// length.
  bool readLine(std::string& line)
  {
    line.clear();
    constexpr size_t kLongestLine = 1 << 16;
    for (char letter = 0; line.size() < kLongestLine && file_.get(letter);)
    {
      if (letter == '\n') return true;
      if (letter != '\r') line += letter;
    }
    return false;
  }

  size_t productOf(size_t a, size_t b) const
  {
    if (b != 0 && a > std::numeric_limits<size_t>::max() / b)
      fail("the header's counts are impossibly large");
    return a * b;
  }

  void layOut()
  {
    size_t column = 0;
    size_t offset = 0;
    for (Field& field : header_.fields)
    {
      const bool known = field.size == 1 || field.size == 2 || field.size == 4 || field.size == 8;
      if (!known) fail("field " + field.name + " has the SIZE " + std::to_string(field.size));
      constexpr size_t kMostElements = 1 << 20;
      if (field.count > kMostElements)
        fail("field " + field.name + " has the COUNT " + std::to_string(field.count));
      field.column = column;
      field.offset = offset;
      column += field.count;
      offset += field.bytes();
    }
    if (header_.points > 0 && offset == 0) fail("the header's points have no bytes");
  }

  void selectAxes()
  {
    const std::array<std::string, 3> names{"x", "y", "z"};
    for (size_t axis = 0; axis < 3; ++axis)
    {
      for (const Field& field : header_.fields)
        if (field.name == names[axis] && field.count > 0) axes_[axis] = field;
      const Field& found = axes_[axis];
      if (found.name.empty()) fail("has no field " + names[axis]);
      const bool isFloat = found.type == 'F' && found.size >= 4;
      const bool isInteger = found.type == 'I' || found.type == 'U';
      if (!isFloat && !isInteger)
        fail("field " + found.name + " has the TYPE " + found.type + " and the SIZE " +
             std::to_string(found.size));
    }
  }

  void readAscii(std::vector<Eigen::Vector3d>& points)
  {
    for (std::string line; std::getline(file_, line);)
    {
      std::istringstream stream(line);
      const std::vector<std::string> words{std::istream_iterator<std::string>(stream), {}};
      if (words.empty()) continue;
      const std::string place = "point " + std::to_string(points.size() + 1);
      if (words.size() != header_.columns())
        fail(place + " has " + counted(words.size(), "number") + "; expected " +
             std::to_string(header_.columns()));
      Eigen::Vector3d point;
      for (size_t axis = 0; axis < 3; ++axis)
      {
        const std::string& word = words[axes_[axis].column];
        char* end = nullptr;
        point[static_cast<Eigen::Index>(axis)] = std::strtod(word.c_str(), &end);
        if (end == word.c_str() || *end != '\0') fail(place + ": \"" + word + "\" is not a number");
      }
      points.push_back(point);
    }
    if (points.size() != header_.points)
      fail("holds " + counted(points.size(), "point") + "; its header states " +
           std::to_string(header_.points));
  }

  [[nodiscard]] size_t bytesLeft() { return fileSize_ - static_cast<size_t>(file_.tellg()); }

  std::string readBytes(size_t count)
  {
    std::string bytes(count, '\0');
    if (!file_.read(bytes.data(), static_cast<std::streamsize>(count))) fail("cannot be read to its end");
    return bytes;
  }

  void readBinary(std::vector<Eigen::Vector3d>& points)
  {
    const size_t expected = productOf(header_.points, header_.stride());
    const size_t available = bytesLeft();
    if (available < expected)
      fail("cut short: " + counted(available, "byte") + " after the header instead of " +
           std::to_string(expected) + ", for " + counted(header_.points, "point"));
    // What follows is no matter: writers fill up the last page, or append notes of their own.
    const std::string bytes = readBytes(expected);
    takePoints(bytes, points,
               [&](const Field& field, size_t i) { return i * header_.stride() + field.offset; });
  }

  static bool isPadding(const Field& field) { return field.name == "_"; }

  [[nodiscard]] size_t strideWithoutPadding() const
  {
    size_t stride = 0;
    for (const Field& field : header_.fields) stride += isPadding(field) ? 0 : field.bytes();
    return stride;
  }

  void dropPadding()
  {
    for (Field& field : header_.fields)
      if (isPadding(field)) field.count = 0;
    layOut();
    selectAxes();
  }

  /// Field by field: all x, then all y, …
  void readCompressed(std::vector<Eigen::Vector3d>& points)
  {
    if (bytesLeft() < 8) fail("cut short: the sizes of the compressed points are missing");
    std::array<uint32_t, 2> sizes{};
    std::memcpy(sizes.data(), readBytes(8).data(), 8);
    const auto [compressedSize, size] = sizes;
    if (bytesLeft() < compressedSize)
      fail("cut short: " + counted(bytesLeft(), "byte") + " of compressed points instead of " +
           std::to_string(compressedSize));
    if (size == productOf(header_.points, strideWithoutPadding()))
      dropPadding();  // PCL lists the padding and leaves it out
    if (size != productOf(header_.points, header_.stride()))
      fail("its compressed points have " + counted(size, "byte") + "; its header states " +
           counted(header_.points, "point") + " of " + counted(header_.stride(), "byte"));
    if (header_.points == 0) return;
    constexpr size_t kHighestRatio = 264;  // of LZF: 3 bytes stand for at most 264
    if (size / kHighestRatio > compressedSize) fail("its compressed points are damaged");
    const std::string compressed = readBytes(compressedSize);
    std::string bytes(size, '\0');
    if (lzf_decompress(compressed.data(), compressedSize, bytes.data(), size) != size)
      fail("its compressed points are damaged");
    takePoints(bytes, points,
               [&](const Field& field, size_t i)
               { return header_.points * field.offset + i * field.bytes(); });
  }

  /// @param offsetOf  where a field of the i-th point stands
  template <class OffsetOf>
  void takePoints(const std::string& bytes, std::vector<Eigen::Vector3d>& points,
                  const OffsetOf& offsetOf) const
  {
    const auto coordinate = [&](size_t axis, size_t i)
    { return element(bytes.data() + offsetOf(axes_[axis], i), axes_[axis]); };
    points.reserve(header_.points);
    for (size_t i = 0; i < header_.points; ++i)
      points.emplace_back(coordinate(0, i), coordinate(1, i), coordinate(2, i));
  }

  template <class Number>
  static double as(const char* bytes)
  {
    Number number;
    std::memcpy(&number, bytes, sizeof(number));
    return static_cast<double>(number);
  }

  static double element(const char* bytes, const Field& field)
  {
    if (field.type == 'F') return field.size == 4 ? as<float>(bytes) : as<double>(bytes);
    const bool isSigned = field.type == 'I';
    switch (field.size)
    {
      case 1:
        return isSigned ? as<int8_t>(bytes) : as<uint8_t>(bytes);
      case 2:
        return isSigned ? as<int16_t>(bytes) : as<uint16_t>(bytes);
      case 4:
        return isSigned ? as<int32_t>(bytes) : as<uint32_t>(bytes);
      default:
        return isSigned ? as<int64_t>(bytes) : as<uint64_t>(bytes);
    }
  }

  std::string path_;
  std::ifstream file_;
  size_t fileSize_ = 0;
  Header header_;
  std::array<Field, 3> axes_;
};
}  // namespace

PcdCloud readPcdFile(const std::string& path)
{
  return PcdReader(path).read();
}

}  // namespace lamap::tools
