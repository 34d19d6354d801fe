#include <lamap_sim/random.h>
#include <lamap_sim/sensor.h>

#include <cmath>
#include <stdexcept>

namespace lamap::sim
{
namespace
{
constexpr double kPi = 3.14159265358979323846;
constexpr double kDegree = kPi / 180;

Eigen::Vector3d directionOf(double azimuth_rad, double elevation_rad)
{
  const SineCosine azimuth = sineCosine(azimuth_rad);
  const SineCosine elevation = sineCosine(elevation_rad);
  return {elevation.cosine * azimuth.cosine, elevation.cosine * azimuth.sine, elevation.sine};
}

/// Beams at the centres of the cells of a grid of angles, centred on the x axis.
void setAngleGrid(SensorModel& sensor, int azimuths, double azimuthSpan_rad, int elevations,
                  double elevationSpan_rad)
{
  sensor.azimuthSpan_rad = azimuthSpan_rad;
  sensor.elevationLow_rad = -elevationSpan_rad / 2;
  sensor.elevationHigh_rad = elevationSpan_rad / 2;
  for (int i = 0; i < azimuths; ++i)
    for (int j = 0; j < elevations; ++j)
      sensor.beams.push_back(directionOf(azimuthSpan_rad * ((i + 0.5) / azimuths - 0.5),
                                         elevationSpan_rad * ((j + 0.5) / elevations - 0.5)));
}

SensorModel sectorLaser()
{
  SensorModel sensor;
  sensor.rangeMax_m = 8;
  setAngleGrid(sensor, 100, 120 * kDegree, 35, 60 * kDegree);
  sensor.headingsPerStop = 3;
  sensor.height_m = 0.45;
  sensor.defaultScans = 12;
  return sensor;
}

SensorModel panTiltLaser()
{
  SensorModel sensor;
  sensor.rangeMax_m = 30;
  setAngleGrid(sensor, 500, 2 * kPi, 178, 150 * kDegree);
  sensor.height_m = 1.0;
  sensor.period_s = 10;
  sensor.defaultScans = 66;
  return sensor;
}

SensorModel lidar16()
{
  SensorModel sensor;
  sensor.rangeMax_m = 100;
  sensor.azimuthSpan_rad = 2 * kPi;
  sensor.elevationLow_rad = -15 * kDegree;
  sensor.elevationHigh_rad = 15 * kDegree;
  constexpr int kSteps = 1800;
  for (int i = 0; i < kSteps; ++i)
    for (int row = 0; row < 16; ++row)
      sensor.beams.push_back(directionOf(2 * kPi * ((i + 0.5) / kSteps - 0.5), (2 * row - 15) * kDegree));
  sensor.height_m = 1.0;
  sensor.period_s = 0.1;
  sensor.defaultScans = 60;
  return sensor;
}

SensorModel planarLaser()
{
  SensorModel sensor;
  sensor.kind = SensorKind::Planar;
  sensor.rangeMax_m = 30;
  sensor.aperture_rad = kPi;
  constexpr int kBeams = 361;
  for (int i = 0; i < kBeams; ++i)
    sensor.beams.push_back(directionOf(sensor.aperture_rad * (i / (kBeams - 1.0) - 0.5), 0));
  sensor.height_m = 0.4;
  sensor.period_s = 0.2;
  sensor.defaultScans = 60;
  return sensor;
}

SensorModel sonar(int echoRanks)
{
  SensorModel sensor;
  sensor.kind = SensorKind::Sonar;
  sensor.rangeMax_m = 15;
  sensor.aperture_rad = 15 * kDegree;
  // Rings of equal width around the axis, so that each ray covers the same solid angle.
  constexpr int kRings = 6;
  sensor.beams.push_back(Eigen::Vector3d::UnitX());
  for (int ring = 1; ring <= kRings; ++ring)
    for (int i = 0; i < 6 * ring; ++i)
    {
      const SineCosine off = sineCosine(sensor.aperture_rad / 2 * ring / kRings);
      const SineCosine around = sineCosine(2 * kPi * i / (6 * ring));
      sensor.beams.emplace_back(off.cosine, off.sine * around.cosine, off.sine * around.sine);
    }
  sensor.pingsPerScan = 120;
  sensor.echoRanks = echoRanks;
  sensor.height_m = 0.5;
  sensor.period_s = 0.05;
  sensor.defaultScans = 12;
  return sensor;
}
}  // namespace

const std::vector<std::string>& sensorNames()
{
  static const std::vector<std::string> names{"sector-laser", "pan-tilt-laser", "lidar16",
                                              "planar-laser", "sonar",          "sonar-range"};
  return names;
}

SensorModel makeSensor(const std::string& name)
{
  SensorModel sensor;
  if (name == "sector-laser")
    sensor = sectorLaser();
  else if (name == "pan-tilt-laser")
    sensor = panTiltLaser();
  else if (name == "lidar16")
    sensor = lidar16();
  else if (name == "planar-laser")
    sensor = planarLaser();
  else if (name == "sonar")
    sensor = sonar(3);
  else if (name == "sonar-range")
    sensor = sonar(1);
  else
    throw std::invalid_argument("sensor = " + name + ": no sensor of this name");
  sensor.name = name;
  return sensor;
}

FieldOfView::FieldOfView(const SensorModel& sensor)
    : kind_(sensor.kind),
      edgeCosine_(
          sineCosine((sensor.kind == SensorKind::Cloud ? sensor.azimuthSpan_rad : sensor.aperture_rad) / 2)
              .cosine)
{
  if (kind_ != SensorKind::Cloud) return;
  lowSine_ = sineCosine(sensor.elevationLow_rad).sine;
  highSine_ = sineCosine(sensor.elevationHigh_rad).sine;
}

bool FieldOfView::contains(const Eigen::Vector3d& direction_sensor) const
{
  const Eigen::Vector3d& d = direction_sensor;
  constexpr double kRounding = 1e-12;  // the beams at the edge belong to it
  if (kind_ == SensorKind::Sonar) return d.x() >= edgeCosine_ - kRounding;
  const double level = std::sqrt(d.x() * d.x() + d.y() * d.y());
  return d.x() >= edgeCosine_ * level - kRounding && d.z() >= lowSine_ - kRounding &&
         d.z() <= highSine_ + kRounding;
}

HeadTurn headTurn(const SensorModel& sensor, int shot)
{
  constexpr double kDown_rad = 20 * kDegree;
  const int step = shot % sensor.pingsPerScan;
  const int sweep = shot / sensor.pingsPerScan;
  return {2 * kPi * (static_cast<double>(step) / sensor.pingsPerScan - 0.5), sweep % 2 == 0 ? 0 : kDown_rad};
}

}  // namespace lamap::sim
