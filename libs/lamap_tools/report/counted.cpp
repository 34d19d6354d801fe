#include <lamap_tools/report/counted.h>

namespace lamap::tools
{
namespace
{
std::string pluralOf(const std::string& noun)
{
  const size_t last = noun.size() - 1;
  const bool afterConsonant = last > 0 && std::string("aeiou").find(noun[last - 1]) == std::string::npos;
  if (noun[last] == 'y' && afterConsonant) return noun.substr(0, last) + "ies";
  if (noun[last] == 'o' && afterConsonant) return noun + "es";
  return noun + "s";
}
}  // namespace

std::string counted(size_t count, const std::string& noun)
{
  return std::to_string(count) + " " + (count == 1 ? noun : pluralOf(noun));
}

}  // namespace lamap::tools
