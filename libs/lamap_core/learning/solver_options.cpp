#include <lamap_core/learning/solver_options.h>

#include <lamap_core/options/legal_range.h>

namespace lamap
{
void DescentOptions::validate() const
{
  requireLegal(alpha >= 1e-12 && alpha <= 1e6, "alpha", alpha, "a number from 1e-12 to 1e6");
  requireLegal(epochs >= 1 && epochs <= 100000, "epochs", epochs, "a whole number from 1 to 100000");
}

void requireIterations(double iterations)
{
  requireLegal(iterations >= 1 && iterations <= 100000, "iterations", iterations,
               "a whole number from 1 to 100000");
}

}  // namespace lamap
