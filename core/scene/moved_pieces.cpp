// See moved_pieces.h.
#include "core/scene/moved_pieces.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

namespace core {

namespace {

using shared::MovedPiece;

constexpr size_t kMostLights = 4, kMostMeshes = shared::kMostMovedPieces - kMostLights;

MovedPiece emptyPiece(IndexRange triangles)
{
    constexpr float kFar = std::numeric_limits<float>::infinity();
    return {glm::vec3(kFar), triangles.begin, glm::vec3(-kFar), triangles.size()};
}

void grow(MovedPiece& piece, glm::vec3 p)
{
    piece.low = min(piece.low, p);
    piece.high = max(piece.high, p);
}

float halfArea(const MovedPiece& piece)
{
    const glm::vec3 d = piece.high - piece.low;
    return d.x * d.y + d.y * d.z + d.z * d.x;
}

/// A box around both; what lies between their triangles counts as moved, too.
MovedPiece joined(const MovedPiece& a, const MovedPiece& b)
{
    const uint32_t end = b.first + (b.count & ~shared::kMovedSeveral);
    return {min(a.low, b.low), a.first, max(a.high, b.high),
            (end - a.first) | shared::kMovedSeveral};
}

/// Joins equally long rows of neighbours, so that a few hundred boxes are left of very many: to
/// find the best pair takes as long as there are boxes, for each that goes.
void joinRows(std::vector<MovedPiece>& pieces)
{
    constexpr size_t kMost = 256;
    const size_t row = (pieces.size() + kMost - 1) / kMost;
    if (row < 2) return;
    std::vector<MovedPiece> rows;
    for (size_t i = 0; i < pieces.size(); ++i) {
        if (i % row == 0)
            rows.push_back(pieces[i]);
        else
            rows.back() = joined(rows.back(), pieces[i]);
    }
    pieces = std::move(rows);
}

/// Joins neighbours until there are no more than `most`: those first whose box wastes least.
void joinNeighbours(std::vector<MovedPiece>& pieces, size_t most)
{
    joinRows(pieces);
    while (pieces.size() > most) {
        size_t best = 0;
        float least = std::numeric_limits<float>::infinity();
        for (size_t i = 0; i + 1 < pieces.size(); ++i) {
            const float waste = halfArea(joined(pieces[i], pieces[i + 1])) - halfArea(pieces[i]) -
                                halfArea(pieces[i + 1]);
            if (waste < least) {
                least = waste;
                best = i;
            }
        }
        pieces[best] = joined(pieces[best], pieces[best + 1]);
        pieces.erase(pieces.begin() + static_cast<std::ptrdiff_t>(best) + 1);
    }
}

/// Meshes of which a vertex has moved.
std::vector<MovedPiece> movedMeshes(const World& before, const World& now)
{
    std::vector<MovedPiece> pieces;
    for (const IndexRange& range : now.movingPieces) {
        MovedPiece piece = emptyPiece(range);
        bool moved = false;
        for (uint32_t i = range.begin; i < range.end; ++i) {
            const WorldTriangle& t = now.triangles[i];
            for (const uint32_t vertex : {t.v0, t.v1, t.v2}) {
                moved = moved || before.positions[vertex] != now.positions[vertex];
                grow(piece, before.positions[vertex]);
                grow(piece, now.positions[vertex]);
            }
        }
        if (moved) pieces.push_back(piece);
    }
    return pieces;
}

/// What of an emitter is not its place.
bool sameButForPlace(const shared::Emitter& a, const shared::Emitter& b)
{
    return a.kind == b.kind && a.radiance == b.radiance && a.offset == b.offset;
}

/// Point and spot lights that have moved or turned; false where that is not all that has changed.
bool findMovedLights(const World& before, const World& now, std::vector<MovedPiece>& pieces)
{
    if (before.emitters.sharesWith(now.emitters)) return true;
    if (before.emitters.size() != now.emitters.size()) return false;
    for (size_t i = 0; i < now.emitters.size(); ++i) {
        const shared::Emitter& a = before.emitters[i];
        const shared::Emitter& b = now.emitters[i];
        const uint32_t kind = b.kind & 0xffu;
        if (!sameButForPlace(a, b)) return false;
        // A triangle that shines belongs to a mesh.
        if (kind == shared::kEmitterTriangle || std::memcmp(&a, &b, sizeof(a)) == 0) continue;
        if (kind != shared::kEmitterPoint && kind != shared::kEmitterSpot) return false;
        MovedPiece piece = emptyPiece({});
        grow(piece, a.a);
        grow(piece, b.a);
        pieces.push_back(piece);
    }
    return true;
}

/// Whether emitters are chosen as before: what has been drawn would have another density.
bool sameChoice(const World& before, const World& now)
{
    constexpr float kRounding = 1e-4f;
    return before.environmentEmitter == now.environmentEmitter &&
           before.sunEmitter == now.sunEmitter &&
           std::equal(before.emitterCdf.begin(), before.emitterCdf.end(), now.emitterCdf.begin(),
                      now.emitterCdf.end(),
                      [](float a, float b) { return std::abs(a - b) <= kRounding; });
}

}  // namespace

bool mayMove(const World& world)
{
    return world.scene && !world.scene->animations.empty();
}

std::optional<std::vector<MovedPiece>> movedPieces(const World& before, const World& now)
{
    std::vector<MovedPiece> lights;
    if (!sameTopology(before, now) || !sameChoice(before, now) ||
        !findMovedLights(before, now, lights))
        return {};
    std::vector<MovedPiece> pieces = movedMeshes(before, now);
    joinNeighbours(pieces, kMostMeshes);
    joinNeighbours(lights, kMostLights);
    pieces.insert(pieces.end(), lights.begin(), lights.end());
    // Directions towards a light are kept in 32 bits, and triangles have no thickness.
    const float margin = 2e-4f * now.radius;
    for (MovedPiece& piece : pieces) {
        piece.low -= margin;
        piece.high += margin;
    }
    return pieces;
}

}  // namespace core
