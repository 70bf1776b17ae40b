// See json_scan.h.
#include "core/base/json_scan.h"

#include "core/base/text.h"

namespace core {

JsonScan scanJson(std::string_view text)
{
    // Sizes of nlohmann's nodes on 64 bits: a value in an array, a key-value node, an object's or
    // array's header.
    constexpr uint64_t kValueBytes = 32, kKeyBytes = 80, kContainerBytes = 48;
    JsonScan scan{{}, text.size()};
    int depth = 0;
    bool inString = false;
    for (size_t i = 0; i < text.size(); ++i) {
        const char c = text[i];
        if (inString) {
            if (c == '\\')
                ++i;
            else if (c == '"')
                inString = false;
            continue;
        }
        if (c == '"') {
            inString = true;
        } else if (c == ',') {
            scan.treeBytes += kValueBytes;
        } else if (c == ':') {
            scan.treeBytes += kKeyBytes;
        } else if (c == '{' || c == '[') {
            scan.treeBytes += kContainerBytes;
            if (++depth > kMaxJsonDepth) {
                scan.problem = "nested deeper than " + std::to_string(kMaxJsonDepth) +
                               " levels at " + placeInText(text, i);
                return scan;
            }
        } else if (c == '}' || c == ']') {
            --depth;
        } else if (c == '\0') {
            scan.problem = "NUL byte at " + placeInText(text, i);
            return scan;
        }
    }
    return scan;
}

}  // namespace core
