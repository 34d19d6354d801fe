#include <lamap_core/legal_range.h>

#include <sstream>
#include <stdexcept>

namespace lamap
{
void requireLegal(bool condition, const char* name, double value, const std::string& legal)
{
  if (condition) return;
  std::ostringstream message;
  message.precision(17);
  message << name << " = " << value << ": must be " << legal;
  throw std::invalid_argument(message.str());
}

}  // namespace lamap
