// The steps of a script, read and checked. A file holds {"steps": [...]}; a step is one of
//   {"do": ACTION, ...its arguments}   see actions.h
//   {"wait": WHAT, "value": N, "timeout": S}
//       loaded | job (the core thread) | samples N | seconds N | frames N | still | finished |
//       reference N (samples) | equal-time | comparison | flip | notice TEXT
//   {"key": "Ctrl+S", "seconds": S}    pressed for so long (0: one frame)
//   {"drag": [[x, y], [x, y]], "button": 0, "frames": N}
//       in [0,1]^2 of the window; 0 left, 1 right, 2 middle
//   {"click": [x, y], "times": 2}   {"cursor": [x, y]}   {"wheel": steps}   {"drop": FILE}
//   {"expect": WHAT, ...}
//       notice TEXT | document NAME | device NAME | samples N | clean | fresh
//   {"random": N, "seed": S, "files": [...], "folder": DIR}   N actions at random, one per frame
//   {"repeat": N, "steps": [...]}
#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include <nlohmann/json_fwd.hpp>

namespace app {

struct ScriptSteps {
    std::unique_ptr<const nlohmann::ordered_json> document;
    std::vector<const nlohmann::ordered_json*> order;  // of the document, repetitions unrolled
};

/// Reads and checks the whole file. Throws core::Error with the place in it.
ScriptSteps readScript(const std::filesystem::path& file);

}  // namespace app
