// What would be lost: by quitting, by another scene, by a new reference. One rule for all of them:
// whoever asks by hand is asked first when there is anything in this list.
#pragma once

#include <string>
#include <vector>

namespace app {

class Session;

/// What takes time to make: rendering, or a person's own.
enum class Part { picture, a, b, reference, background, path };

/// Some of these.
struct Parts {
    bool picture = false, a = false, b = false, reference = false, background = false, path = false;
    friend bool operator==(const Parts&, const Parts&) = default;
};
inline constexpr Parts kAllParts{true, true, true, true, true, true};
/// Those that belong to one scene.
inline constexpr Parts kPartsOfScene{
    .picture = true, .a = true, .b = true, .reference = true, .path = true};

struct Loss {
    Part part = Part::picture;
    std::string text;  // as sentences begin: "the picture: 1204 samples per pixel, 3 minutes ..."
};

/// What took more than a minute of rendering, or is a path of the user's own, and would be kept
/// nowhere if `parts` went. Empty: they may go at once.
std::vector<Loss> lossesOf(const Session& session, const Parts& parts = kAllParts);

/// Each of them that a file can hold into a new file of its own, in the current folder: what has
/// been written is told. `picture`: the name of the picture's file; empty: a new one.
void saveLosses(Session& session, const std::vector<Loss>& losses, const std::string& picture = {});

/// Whether saveLosses can save it: what an export is about to write is not there yet, nor is a
/// reference before its first samples.
bool canBeSaved(const Session& session, const Loss& loss);

/// "75 seconds", "3 minutes", "2.5 hours".
std::string spanText(double seconds);

}  // namespace app
