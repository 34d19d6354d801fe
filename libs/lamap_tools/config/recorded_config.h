#pragma once

#include <mrpt/config/CConfigFileBase.h>

#include <map>
#include <set>
#include <string>
#include <vector>

namespace lamap::tools
{
/** A configuration that other values are laid over and that remembers what was asked of it.
 *
 * MRPT's loaders ignore keys they do not know and take "30m" for 30 and "abc" for 0. What they asked for, and
 * the default they gave, tells afterwards which keys nothing reads and which values are not what their reader
 * takes them for. Names of sections and keys are compared without case, as MRPT does.
 */
class RecordedConfig : public mrpt::config::CConfigFileBase
{
 public:
  /// @param base must outlive this.
  explicit RecordedConfig(const mrpt::config::CConfigFileBase& base) : base_(base) {}

  /// Lays a value over what the configuration holds.
  void setValue(const std::string& section, const std::string& key, const std::string& text);

  /** @param prefix    of the names of sections that somebody should have read
   *  @param shorten  whether messages give section and key as `insertOpts.maxRange`, without the prefix and
   * "_"
   *  @throws std::runtime_error naming the first section or key nobody asked for and the nearest that
   * somebody did, or the first value that is not a number where one was asked for */
  void requireAllRead(const std::string& prefix, bool shorten) const;

  /// Sections in which something was asked for, in no order.
  [[nodiscard]] std::vector<std::string> askedSections() const;

  void getAllSections(std::vector<std::string>& sections) const override;
  void getAllKeys(const std::string& section, std::vector<std::string>& keys) const override;
  void clear() override;

 protected:
  void writeString(const std::string& section, const std::string& name, const std::string& text) override;
  std::string readString(const std::string& section, const std::string& name, const std::string& defaultText,
                         bool failIfNotFound) const override;

 private:
  struct NoCase
  {
    bool operator()(const std::string& a, const std::string& b) const;
  };
  void collectKeys(const std::string& section, std::vector<std::string>& keys) const;

  using DefaultsByKey = std::map<std::string, std::string, NoCase>;

  const mrpt::config::CConfigFileBase& base_;
  std::map<std::string, std::map<std::string, std::string, NoCase>, NoCase> overlay_;
  mutable std::map<std::string, DefaultsByKey, NoCase> asked_;
};

}  // namespace lamap::tools
