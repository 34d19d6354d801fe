#include <lamap_tools/report/counted.h>

namespace lamap::tools
{
namespace
{
std::string pluralOf(const std::string& noun)
{
  const size_t last = noun.size() - 1;
  const bool becomesIes =
      last > 0 && noun[last] == 'y' && std::string("aeiou").find(noun[last - 1]) == std::string::npos;
  return becomesIes ? noun.substr(0, last) + "ies" : noun + "s";
}
}  // namespace

std::string counted(size_t count, const std::string& noun)
{
  return std::to_string(count) + " " + (count == 1 ? noun : pluralOf(noun));
}

}  // namespace lamap::tools
