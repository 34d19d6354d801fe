#pragma once

#include <mrpt/serialization/CSerializable.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace lamap::tools
{
/** Reads the entries of a rawlog one after the other: plain or gzip-compressed, as a sequence of objects
 * (actions and sensory frames, or observations, in any mixture) or as a whole CRawlog.
 *
 * Memory is bounded by the largest entry. A damaged entry cannot make it take more than 64 times the file's
 * size and 256 MiB, or eight times that size and 2 GiB, whichever is less. Sets MRPT's folder of externally
 * stored images
 * (`<log>_Images` and what else MRPT looks for) to that of this log.
 */
class RawlogFile
{
 public:
  /// How far a log can be read without harm, and why not farther.
  struct Limit
  {
    uint64_t objects = 0;
    std::string damage;
  };

  /// What reading a log in a child process found out.
  struct Trial
  {
    std::optional<Limit> limit;   ///< nothing if all is well, or cut short in an orderly way
    bool stopped = false;         ///< because it was asked to: nothing else is known
    std::vector<uint8_t> survey;  ///< what the surveyor returned
  };
  using Surveyor = std::function<std::vector<uint8_t>(RawlogFile&)>;

  /** MRPT may crash on damaged entries, so a log is first read in a child process.
   * @param surveyor  reads the log to its end; what it learns on the way it returns
   * @throws std::runtime_error as the constructor */
  [[nodiscard]] static Trial tryReading(const std::string& path, const Surveyor& surveyor,
                                        const std::function<bool()>& shouldStop);

  /// @throws std::runtime_error naming the file if it cannot be opened or its beginning is not a rawlog's.
  explicit RawlogFile(const std::string& path, std::optional<Limit> limit = std::nullopt);
  ~RawlogFile();
  RawlogFile(const RawlogFile&) = delete;
  RawlogFile& operator=(const RawlogFile&) = delete;

  /// The next entry; nothing after the last one that can be read.
  [[nodiscard]] mrpt::serialization::CSerializable::Ptr next();

  /// What is wrong with the rest of the log, once next() has met it; nothing while all is well.
  [[nodiscard]] const std::optional<std::string>& damage() const { return damage_; }

 private:
  mrpt::serialization::CSerializable::Ptr readObject();

  class Stream;
  std::string path_;
  std::optional<Limit> limit_;
  std::unique_ptr<Stream> stream_;
  size_t memoryLimit_ = 0;
  uint64_t entries_ = 0;
  std::optional<std::string> damage_;
  std::function<void()> onEntry_;
  /// Read ahead to see whether it is a rawlog at all.
  mrpt::serialization::CSerializable::Ptr first_;
  /// A CRawlog among the entries whose own entries are being given out.
  mrpt::serialization::CSerializable::Ptr whole_;
  size_t nextInWhole_ = 0;
};

}  // namespace lamap::tools
