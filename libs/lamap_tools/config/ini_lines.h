#pragma once

#include <functional>
#include <string>

namespace lamap::tools
{
/** Refuses lines of an .ini file that MRPT's reader would silently ignore: in the sections asked about, every
 * line that is neither empty, a comment nor a continued one must be "key = value", and no key may stand twice
 * in a section (case does not count).
 * @throws std::runtime_error naming the line's number, its text and its section */
void requireAssignments(const std::string& path,
                        const std::function<bool(const std::string& section)>& isAskedAbout);

}  // namespace lamap::tools
