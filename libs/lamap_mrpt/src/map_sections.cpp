#include <lamap_mrpt/map_sections.h>
#include <lamap_mrpt/nearest_name.h>

#include <algorithm>
#include <cctype>
#include <stdexcept>

namespace lamap
{
namespace
{
bool sameIgnoringCase(const std::string& a, const std::string& b)
{
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](unsigned char x, unsigned char y) { return std::tolower(x) == std::tolower(y); });
}
}  // namespace

void requireKnownSections(const mrpt::config::CConfigFileBase& source, const std::string& prefix)
{
  std::vector<std::string> known;
  for (const char* end : {kCreationSection, kInsertSection, kLikelihoodSection, kRenderSection})
    known.push_back(prefix + end);
  std::vector<std::string> sections;
  source.getAllSections(sections);
  const std::string start = prefix + "_";
  for (const std::string& section : sections)
  {
    if (!sameIgnoringCase(section.substr(0, start.size()), start)) continue;
    if (std::any_of(known.begin(), known.end(),
                    [&](const auto& one) { return sameIgnoringCase(section, one); }))
      continue;
    throw std::invalid_argument(withoutBrackets("unknown section \"" + section + "\" of " + nameOf(source) +
                                                "; the nearest one is \"" + nearestOf(section, known) +
                                                "\""));
  }
}

std::vector<std::string> genericMapKeys()
{
  return {"enableSaveAs3DObject", "enableObservationLikelihood", "enableObservationInsertion"};
}

void StoredOptions::handTo(CLearnedMap& map) const
{
  map.likelihoodOptions = likelihood;
  map.renderingOptions = rendering;
  map.genericMapParams = generic;
}

void writeOptions(const TOptionGroup& insertion, const CLearnedMap& map, ByteWriter& out)
{
  insertion.write(out);
  map.likelihoodOptions.write(out);
  map.renderingOptions.write(out);
  out.number(map.genericMapParams.enableSaveAs3DObject);
  out.number(map.genericMapParams.enableObservationLikelihood);
  out.number(map.genericMapParams.enableObservationInsertion);
}

StoredOptions readOptions(TOptionGroup& insertion, ByteReader& in)
{
  insertion.read(in);
  StoredOptions stored;
  stored.likelihood.read(in);
  stored.rendering.read(in);
  stored.generic.enableSaveAs3DObject = in.number<bool>();
  stored.generic.enableObservationLikelihood = in.number<bool>();
  stored.generic.enableObservationInsertion = in.number<bool>();
  return stored;
}

void refuseVersion(const char* className, uint8_t version, uint8_t newestKnown)
{
  const std::string what = "a " + std::string(className) + " of format version " + std::to_string(version);
  const std::string known = "; this program reads up to version " + std::to_string(newestKnown);
  throw std::runtime_error(what + known +
                           (version > newestKnown ? ": it was written by a newer mrpt-lamap" : ""));
}

}  // namespace lamap
