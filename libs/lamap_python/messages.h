#pragma once

#include <mrpt/system/COutputLogger.h>

#include <string>
#include <utility>
#include <vector>

namespace lamap::python
{
/// What maps said: the level of Python's logging, and the text.
using Messages = std::vector<std::pair<int, std::string>>;

/// While it exists, what redirected maps say in this thread goes to a list.
class CollectedMessages
{
 public:
  explicit CollectedMessages(Messages& messages);
  ~CollectedMessages();
  CollectedMessages(const CollectedMessages&) = delete;
  CollectedMessages& operator=(const CollectedMessages&) = delete;

 private:
  Messages* before_;
};

/// From now on a map says nothing on the terminal.
void redirectMessages(mrpt::system::COutputLogger& map);

/// Hands messages to logging.getLogger("lamap"). @throws what a handler raises
void logMessages(const Messages& messages);

}  // namespace lamap::python
