# The public face of the library: what is installed, and which symbols it shows. All else is the library's own.

# The headers that users need, and what these include. Named by library and room, as they are included.
set(LAMAP_PUBLIC_HEADERS
  lamap_core/bgk/kernel.h
  lamap_core/bgk/map.h
  lamap_core/bgk/options.h
  lamap_core/bgk/reading.h
  lamap_core/features/compact_kernel.h
  lamap_core/features/compact_sum.h
  lamap_core/features/feature_options.h
  lamap_core/features/lattice.h
  lamap_core/features/logodds.h
  lamap_core/features/packed_sites.h
  lamap_core/features/site_set.h
  lamap_core/gp/map.h
  lamap_core/gp/options.h
  lamap_core/gp/reading.h
  lamap_core/grid/cell.h
  lamap_core/grid/cell_accessor.h
  lamap_core/grid/cell_cubes.h
  lamap_core/grid/cell_extent.h
  lamap_core/grid/cell_options.h
  lamap_core/grid/cell_place.h
  lamap_core/grid/cell_sums.h
  lamap_core/grid/evidence.h
  lamap_core/grid/evidence_block.h
  lamap_core/grid/evidence_map.h
  lamap_core/grid/octant_rule.h
  lamap_core/grid/reading.h
  lamap_core/grid/scan_blocks.h
  lamap_core/grid/state_thresholds.h
  lamap_core/hilbert/map.h
  lamap_core/hilbert/options.h
  lamap_core/hilbert/state.h
  lamap_core/learning/solver_options.h
  lamap_core/math/workers.h
  lamap_core/options/legal_range.h
  lamap_core/options/option.h
  lamap_core/options/option_table.h
  lamap_core/overlapping/map.h
  lamap_core/overlapping/model.h
  lamap_core/overlapping/model_index.h
  lamap_core/overlapping/model_scan.h
  lamap_core/overlapping/options.h
  lamap_core/overlapping/pending_scans.h
  lamap_core/overlapping/reading.h
  lamap_core/scan/depth_view.h
  lamap_core/scan/ray_selection.h
  lamap_core/scan/scan.h
  lamap_core/training/hilbert_sampling.h
  lamap_core/training/sampling_options.h
  lamap_core/training/sampling_rules.h
  lamap_mrpt/compat/mrpt_compat.h
  lamap_mrpt/files/byte_stream.h
  lamap_mrpt/learned_map/CLearnedMap.h
  lamap_mrpt/learned_map/lazy.h
  lamap_mrpt/learned_map/nearest_cells.h
  lamap_mrpt/maps/CBGKMap.h
  lamap_mrpt/maps/CGPMap.h
  lamap_mrpt/maps/CHilbertMap.h
  lamap_mrpt/maps/COverlappingHilbertMap.h
  lamap_mrpt/maps/learner_map.h
  lamap_mrpt/options/option_group.h
)

# What these headers declare and do not define, in namespace lamap: classes of the core with all their members, …
set(LAMAP_PUBLIC_CORE_CLASSES
  Scan RangeOptions SamplingOptions
  BgkStructure BgkInference BgkReading BgkMap
  GpStructure GpInference GpReading GpMap
  HilbertStructure HilbertInference HilbertUncertainty HilbertMap
  OverlappingStructure OverlappingInference OverlappingReading OverlappingHilbertMap ModelPose
  OptionTable
)
# … MRPT's classes, also with what their type information and inherited constructors need, …
set(LAMAP_PUBLIC_MRPT_CLASSES
  CLearnedMap CBGKMap CGPMap CHilbertMap COverlappingHilbertMap
  NearestCells TOptionGroup
)
# … and functions. * is any text, ? any character. Of LearnerMap, what MRPT calls through its own classes is left out, of
# EvidenceMap what the maps alone call.
set(LAMAP_PUBLIC_FUNCTIONS
  cellCentre cellAt presetOptions
  operator???lamap::Bgk operator???lamap::Gp operator???lamap::HilbertStructure operator???lamap::Overlapping
  operator???lamap::Evidence
  EvidenceMap*::cell EvidenceMap*::at EvidenceMap*::visitCells EvidenceMap*::memoryBytes EvidenceMap*::evidence
  EvidenceMap*::restoreEvidence EvidenceMap*::cellBounds EvidenceMap*::emptyAround
  EvidenceMap*::structure EvidenceMap*::planarLayer EvidenceMap*::clear EvidenceMap*::empty
  EvidenceMap*::merge EvidenceMap*::EvidenceMap
  CellAccessor*::CellAccessor CellAccessor*::cell CellAccessor*::at CellAccessor*::prob CellAccessor*::state
  CellAccessor*::emptyAroundLast CellAccessor*::blocksIn CellAccessor*::readBlock CellAccessor*::readPrior
  LearnerMap*::LearnerMap LearnerMap*::T*Options:: LearnerMap*::TMapDefinition::TMapDefinition
  LearnerMap*::TMapDefinition::?TMapDefinition LearnerMap*::MapDefinition LearnerMap*::CreateFromMapDefinition
  LearnerMap*::alias LearnerMap*::core LearnerMap*::creationOptions LearnerMap*::estimate LearnerMap*::isEmpty
  LearnerMap*::memoryBytes LearnerMap*::planarLayer LearnerMap*::rangeLimits LearnerMap*::resolution
  LearnerMap*::stateThresholds LearnerMap*::visit LearnerMap*::cellBounds LearnerMap*::emptyAround
)

# Hides every symbol of a library but those above. By the linker, not by attributes: the headers of the core stay free
# of export macros, and the same objects serve the library, the tool and the tests.
function(lamap_show_only_public_symbols target)
  set(patterns "")
  foreach(class ${LAMAP_PUBLIC_CORE_CLASSES} ${LAMAP_PUBLIC_MRPT_CLASSES})
    string(APPEND patterns "    lamap::${class}::*;\n")
  endforeach()
  # No blanks: a name with a blank would have to be quoted, and quoted names have no wildcards.
  foreach(class ${LAMAP_PUBLIC_MRPT_CLASSES} LearnerMap*)
    foreach(symbol "typeinfo?for?lamap::${class}" "vtable?for?lamap::${class}")
      string(APPEND patterns "    ${symbol};\n    ${symbol}::T*;\n")
    endforeach()
  endforeach()
  string(APPEND patterns "    non-virtual?thunk?to?lamap::CLearnedMap::*;\n")
  foreach(function ${LAMAP_PUBLIC_FUNCTIONS})
    string(APPEND patterns "    lamap::${function}*;\n")
  endforeach()
  set(script ${PROJECT_BINARY_DIR}/public_symbols.map)
  file(CONFIGURE OUTPUT ${script} CONTENT "{\n  global: extern \"C++\" {\n${patterns}  };\n  local: *;\n};\n" @ONLY)
  target_link_options(${target} PRIVATE LINKER:--version-script=${script})
  set_property(TARGET ${target} APPEND PROPERTY LINK_DEPENDS ${script})
endfunction()
