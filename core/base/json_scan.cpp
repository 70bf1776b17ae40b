// See json_scan.h.
#include "core/base/json_scan.h"

#include "core/base/text.h"

namespace core {

JsonScan scanJson(std::string_view text)
{
    JsonScan scan;
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
            ++scan.commas;
        } else if (c == ':') {
            ++scan.colons;
        } else if (c == '{' || c == '[') {
            ++scan.containers;
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
