#pragma once

#include <lamap_core/options/shared_options.h>

// Options that both kinds of Hilbert maps have, each group in the order in which files hold it.
// @tparam Self the struct of options, which has members of these names
namespace lamap
{
/// features, gamma, cutoff, latticeSpacing, components, seed, priorPrecision
template <typename Self>
OptionTableOf<Self>& addFeatureOptions(OptionTableOf<Self>& table)
{
  return table
      .add(
          "features", &Self::features, oneOf({"compact", "nystroem"}),
          "kernels of compact support on a lattice, or Nystroem components of the full kernel (thesis 2.4.2)")
      .add("gamma", &Self::gamma,
           OptionTraits{"m^-2"}.from(1e-6).to(1e6).usually("14 (compact) or 3 (nystroem)"),
           "the kernel decreases as exp(-gamma d^2)")
      .add("cutoff", &Self::cutoff, plain().from(1e-6).to(0.999),
           "subtracted from the compact kernel, which ends at its support sqrt(ln(1/cutoff)/gamma)")
      .add("latticeSpacing", &Self::latticeSpacing, metres().from(1e-4).to(4e3),
           "distance between neighbouring compact kernels, 0.13 to 1.15 times their support")
      .add("components", &Self::components, plain().from(1).to(5000),
           "number m of nystroem features; the time to train, and to load a saved map, grows with its cube")
      .add("seed", &Self::seed, plain().from(0).to(kWholeMost),
           "seed of the inducing points and of the order in stochastic gradient descent")
      .add("priorPrecision", &Self::priorPrecision, plain().from(1e-6).to(1e6),
           "prior precision of each weight: the L2 penalty")
      .onlyWhere({"components"}, {{"features", {"nystroem"}}})
      .onlyWhere({"seed"}, {{"features", {"nystroem"}}, {"solver", {"sgdL1", "sgdL2"}}});
}

/// trainingPoints, freeMargin, freeResolution, hitWeight, freeWeight
template <typename Self>
OptionTableOf<Self>& addSamplingOptions(OptionTableOf<Self>& table)
{
  return table
      .add("trainingPoints", &Self::trainingPoints, oneOf({"cells", "points"}),
           "hit and free cells of a scan once each, or every hit and free sample where it is")
      .add("freeMargin", &Self::freeMargin, metres().from(0).to(kMetresMost),
           "distance of the last free sample from its ray's hit")
      .add("freeResolution", &Self::freeResolution, metres().from(1e-3).to(kMetresMost),
           "distance between free samples, from there back to the sensor")
      .add("hitWeight", &Self::hitWeight, plain().above(0).to(1e3), "weight of a hit")
      .add("freeWeight", &Self::freeWeight, plain().from(0).to(1e3),
           "weight of a free point; 0: no free points");
}

/// iterations, and what Self::DescentOptions describes
template <typename Self>
OptionTableOf<Self>& addSolverOptions(OptionTableOf<Self>& table)
{
  return table
      .add("iterations", &Self::iterations, plain().from(1).to(1e5).usually("10 (incremental) or 25"),
           "most iterations of lbfgs")
      .onlyWhere({"iterations"}, {{"solver", {"lbfgs"}}})
      .template include<typename Self::DescentOptions>();
}

/// beamWidth, echoWeight, noEchoWeight, usePoseCovariance, rangeStd, pointStd
template <typename Self>
OptionTableOf<Self>& addUncertaintyOptions(OptionTableOf<Self>& table)
{
  return addWidthOptions(table)
      .add("rangeStd", &Self::rangeStd, metres().from(0).to(100),
           "standard deviation of a range: points are uncertain along their rays")
      .add("pointStd", &Self::pointStd, metres().from(0).to(100),
           "standard deviation of a point along each axis");
}

}  // namespace lamap
