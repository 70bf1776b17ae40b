// What the progressive CPU methods share but for their samples: the hierarchy, the camera, a film
// filled tile by tile (tiled_film.h), first hits.
#pragma once

#include "core/methods/renderer.h"
#include "core/methods/sky_slot.h"
#include "core/methods/tiled_film.h"
#include "core/trace/accel.h"

namespace core {

/// A method adds setParams, and advance, which fills `film_`. It keeps nothing of the view before.
class TiledRenderer : public Renderer {
public:
    void setWorld(std::shared_ptr<const World> world, const Progress& progress) override;
    void prepare(const AnyParams& params, const Progress& progress) override;
    void setView(const View& view, Start start) override;
    /// Pieces are tiles, far below any wish.
    void setPace(const Pace&) override {}
    RenderProgress progress() const override { return film_.progress(); }
    Estimate read(Reading what) override { return film_.estimate(what); }
    Aovs aovs() override { return surfaces(camera_, film_.size(), Sight::first); }
    Aovs surfaces(const Camera& camera, glm::uvec2 size, Sight sight) override;
    RenderStats stats() const override;

protected:
    virtual void setParams(const AnyParams& params) = 0;

    /// The world's settings for the film's size; what a method adds to them is left as it is there.
    shared::PathSettings frameSettings() const;
    shared::CameraData frameCamera() const;
    /// What the scene and the camera hold (kFeature bits).
    uint32_t frameFeatures() const;

    /// From now on; for setParams of methods that connect to the environment.
    void drawSky(SkySampling sampling);
    /// The world, and the regions of its sky that it is drawn by.
    shared::SceneView frameScene() const;

    std::unique_ptr<Accel> accel_;
    SkySlot sky_;
    Camera camera_;
    bool centred_ = false;  // see View
    TiledFilm film_;
};

}  // namespace core
