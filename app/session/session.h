// Everything that the viewer is, without a window: the scene, the camera, the parameters, the
// threads, the pictures. The panel, keys and scripts edit its parts; `update` notices what changed
// and orders only what that invalidates.
#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <variant>
#include <vector>

#include "app/camera/camera_track.h"
#include "app/camera/navigation.h"
#include "app/camera/surroundings.h"
#include "app/camera/view_history.h"
#include "app/files/stats.h"
#include "app/pictures/comparison.h"
#include "app/pictures/convergence.h"
#include "app/pictures/picture.h"
#include "app/pictures/picture_judge.h"
#include "app/pictures/reference_job.h"
#include "app/pictures/render_thread.h"
#include "app/pictures/scene_pictures.h"
#include "app/pictures/view_params.h"
#include "app/session/notices.h"
#include "app/session/settings.h"
#include "app/session/window_layout.h"
#include "core/base/worker.h"

namespace app {

/// A scene that is on show.
struct Document : ShownScene {
    double loadSeconds = 0;
    std::vector<std::string> warnings;
};

/// What the loader hands back: a whole scene, or the present one at another time.
struct Loaded {
    Document document;
    bool pose = false;
};

class PendingSaves;
class SettingsKeeper;
class SaveQueue;
struct SaveItem;
struct Replay;

/// Time of the scene's own animation.
struct AnimationPlayer {
    bool playing = false, loop = true;
    double time = 0, speed = 1;
    double duration = 0;  // 0: the scene has none
};

/// What takes its time and can be cancelled by itself.
enum class Work : uint32_t { load, background, equalTime, path, animation };

}  // namespace app

template <> struct core::EnumNames<app::Work> {
    static constexpr std::array<std::string_view, 5> names{"load", "background", "equal-time",
                                                           "path", "animation"};
};

namespace app {

inline constexpr size_t kWorks = core::EnumNames<Work>::names.size();

/// The name of the loader's job that makes a pose of the scene's animation.
inline constexpr const char* kPoseJob = "the animation's pose";
/// ... and of the core thread's that renders a reference.
inline constexpr const char* kReferenceJob = "reference";

struct SessionOptions {
    SceneOptions scene;          // what to load first
    std::string camera;          // name, index or file; empty: the scene's first
    std::filesystem::path path;  // a camera path to begin with
    RenderParams render;
    bool methodGiven = false;  // `render.method` counts; else its kept parameters do
    bool validation = false;
    std::filesystem::path settings;  // empty: none are kept
    bool quiet = false;
    float uiScale = 0;     // of the letters, for this run; 0: as kept
    bool builtIn = false;  // the built-in scene stands in for a first one that cannot be loaded
    std::filesystem::path cacheFolder{};  // of small pictures of scenes; empty: none are kept
    RendererFactory factory = viewRenderers();
    std::function<void()> onPicture{};  // on another thread: there is a new picture to take
};

class Session {
public:
    explicit Session(const SessionOptions& options);
    ~Session();

    /// Once per frame: takes what the threads have finished, moves what moves by itself (paths,
    /// animations), orders what changed. `pictureArea` is what the window has for the picture, in
    /// pixels. Never blocks.
    void update(double seconds, glm::uvec2 pictureArea);

    /// Whether something will change without anybody's doing: else the window may sleep until the
    /// next event.
    bool busy() const;

    // --- parts that may be edited at any time
    Settings settings;    // view, panels, presets, recent files, parameters of methods not in use
    RenderParams render;  // device, method and its parameters, limits
    Navigation navigation;
    CameraTrack track;
    AnimationPlayer player;
    Notices notices;
    bool paused = false;
    std::array<Slot, 2> slots;  // of the compare slider
    bool comparing = false;
    bool flying = false;         // WASD moves; else orbiting
    bool holdReference = false;  // the reference is shown while its key is held
    double referenceKeySeconds = 0;
    std::array<bool, 3> dragging{};  // by which of the mouse's buttons the camera is being moved
    double muchSeconds = 60;         // rendering longer than this is not lost unasked: see losses.h
    bool inspecting = false;         // values of pixels are looked at: all that is known is wanted
    uint64_t referenceSamples = 1024;  // per pixel, of a reference that is asked for
    std::string referenceMethod;       // ... and what it is rendered with; empty: as the picture
    /// What A and B are rendered with at equal time, where it has been chosen: see sideParams().
    std::array<std::optional<RenderParams>, 2> chosenParams;

    // --- method
    /// Another method with its parameters as they were last; throws core::Error when there is none
    /// of that name.
    void chooseMethod(std::string_view id);
    /// The parameters, and with them their method; those of the method before are kept.
    void chooseParams(const core::AnyParams& params);

    // --- scene
    void load(const SceneOptions& scene);
    void load(const std::filesystem::path& file);  // with the options of the first scene
    /// The scene on show once more with another environment (see core::LoadOptions): view, camera
    /// path, saved views and animation stay; scenes to come have it, too. Nothing without a scene.
    void setEnvironment(const std::string& what);
    void replay(const std::filesystem::path& picture);
    void cancel();           // all works()
    void cancel(Work work);  // nothing when it does not run
    /// What runs and can be cancelled, the one begun last first.
    std::vector<Work> works() const;
    const Document* document() const { return document_.get(); }
    bool settled() const;  // there is a scene, and no other on its way
    const ScenePictures& pictures() const { return pictures_; }

    // --- camera
    bool isMoving() const;  // or has moved a moment ago
    /// whenever the hand has moved the camera: pictures come small and quick for a moment
    void moved();
    void useSceneCamera(size_t index);
    core::Camera homeCamera() const;  // where goHome() leads; needs a document
    void goHome();  // the scene's camera that was used last, at first the one it began with
    void goBack();  // the view that one rested at before
    void goForward();
    void saveCamera(const std::string& name);
    const std::vector<SavedCamera>& savedCameras() const { return savedCameras_; }
    void useSavedCamera(size_t index);
    void removeSavedCamera(size_t index);
    std::string cameraText() const;             // JSON, for the clipboard
    void pasteCamera(const std::string& json);  // a failure is a notice
    /// in [0,1]^2 of the picture's area: pivot and focus go to what is there
    void focusAt(glm::dvec2 position);
    /// A drag by hand, as Navigation has them: walls may stop it (settings.view.walls).
    void orbit(glm::dvec2 drag);
    void pan(glm::dvec2 drag);
    /// The wheel with the cursor at `position`, in [0,1]^2 of the picture's area; led back, the
    /// same.
    void dolly(double steps, glm::dvec2 position);
    /// The whole scene; from within a room as much of it as can be seen without leaving it.
    void frameScene();
    bool insideSolid() const { return insideSolid_; }  // at rest: see surroundings.h

    // --- pictures
    void restart();
    /// Exposes for the picture on show: see metering.h. One without light changes nothing.
    void expose();
    std::shared_ptr<const Picture> picture() const { return picture_; }
    /// Where a picture stands in the picture's area, in fractions of it.
    Area placeOf(const Picture& picture) const;
    Area placeOf(glm::uvec2 size) const;  // of an image that is not of this view
    bool hasNews() const;                 // a picture newer than that waits for the next update
    uint64_t generation() const { return generation_; }  // of the newest order
    /// What is on show now, or its first whole sample: at once where the view goes, else within
    /// seconds, with its variance and first hits.
    void save(const std::filesystem::path& file);
    /// A side of the slider, or the reference, as it is now. Nothing without one.
    void saveSlot(size_t side, const std::filesystem::path& file);
    void saveReference(const std::filesystem::path& file);
    void savePath(const std::filesystem::path& file);  // the camera path, at once
    /// Whether a picture of the slider, or the reference, is in a file.
    bool isSaved(const std::shared_ptr<const void>& work) const;
    bool saving() const;      // a file is still to be written
    bool saveFailed() const;  // one could not be since save() or beginSaves() was called last
    void beginSaves() { saveFailed_ = false; }
    /// The scene at the instant of the picture on show; none without a picture, or when it is of
    /// another scene, or of another instant though nothing plays.
    std::optional<ShownScene> shownScene() const;
    /// What a screenshot carries, so that its view can be had again; empty without that scene.
    core::Metadata pictureMetadata() const;
    /// Seconds of rendering in the picture that no file has; 0 where it is one of another view than
    /// is rendered now.
    double unsavedSeconds() const;
    /// Renders every frame of the track to numbered files, in the core thread, on the CPU.
    void exportTrack(const std::filesystem::path& pattern, uint32_t samples);

    // --- reference, comparison
    /// On the CPU with the parameters of the picture, or with those last used of the method named,
    /// as deep as the picture. Throws core::Error when there is none of that name on the CPU.
    void startReference(uint64_t samples, std::string_view method = {});
    /// The picture on show, whatever is rendered afterwards; with its variance where that is known
    /// within seconds. What another device or method makes of the view is measured against it.
    void keepAsReference();
    void loadReference(const std::filesystem::path& file);
    void dropReference();
    std::shared_ptr<const Reference> reference() const { return reference_; }
    bool referenceFits() const;  // whether it shows what is rendered: same scene, camera and size
    bool referenceFits(const Picture& picture) const;  // ... what the picture shows
    /// False, with a word, without shownScene().
    bool storeSlot(size_t side);
    /// A becomes B with all that belongs to it. Not during an equal-time run, which fills both.
    void swapSlots();
    void compareEqualTime(const RenderParams& a, const RenderParams& b, double seconds);
    /// What a side is rendered with at equal time: as chosen, else as its picture was, else as the
    /// panel says.
    RenderParams sideParams(size_t side) const;
    /// Of the pictures that are kept as A and B; null without both, and until it is measured.
    std::shared_ptr<const PictureComparison> comparison() const { return judge_.comparison(); }
    std::shared_ptr<const FlipMap> flip() const { return judge_.flip(); }
    const EqualTime& equalTime() const { return equalTime_; }
    const Convergence& convergence() const { return convergence_; }
    void clearCurves() { convergence_.clearPast(); }

    // --- what runs
    core::JobStatus loading() const { return loader_.status(); }
    core::JobStatus coreThread() const { return core_.status(); }
    RenderThreadStatus rendering() const { return renderThread_.status(); }

private:
    /// What rays find for the hand: where to stand in a room, or the surface at a point.
    using Found = std::variant<std::optional<Standpoint>, std::optional<glm::dvec3>>;

    /// What rays find around a camera at rest, and on the way to it.
    struct LookedAround {
        bool inside = false, through = false;
    };

    /// A picture that is to be the reference, without its variance when `until` has come.
    struct KeptPicture {
        std::shared_ptr<const Picture> picture;
        std::shared_ptr<const core::World> world;  // that it shows
        double time = 0, until = 0;
    };

    void startLoading(const SceneOptions& scene);
    void takeLoaded();
    void show(const Document& document);
    void enter();
    void beginAt(const core::Camera& camera);
    void applyReplay();
    void loadFirstPath();
    void showBuiltIn();
    void keepPicture();
    void takeReference();
    void takePicture();
    void noteBrightness();
    void handOver(std::vector<SaveItem> items);
    void endSaves(const char* why);
    uint64_t runOf(Work work) const;
    void noteWorks();
    void tellEnds();
    void animate(double seconds);
    void followSceneCamera();
    void followCamera(size_t index);
    void takeCamera(const core::Camera& camera);
    void goTo(const std::optional<Viewpoint>& viewpoint);
    glm::dvec2 inPicture(glm::dvec2 position) const;
    void seek(const char* name, const std::function<Found(std::stop_token)>& find);
    void take(const Found& found);
    void stand(const std::optional<Standpoint>& standpoint);
    void takeLookout();
    Reach reach() const;
    void noteStop(bool stopped);
    void lookAround();
    void learn(const LookedAround& found);
    void keepCameras();
    Settings settingsToKeep();
    void recallCameras();
    bool referenceFits(const RenderRequest& request) const;
    bool wantsVariance() const;
    void takeReferencePicture();
    void becomeReference(const KeptPicture& kept);
    void completeSlots();
    bool coreIsBusy(const char* but);
    void takeEqualTime();
    std::string sceneName() const;
    void judge();
    void noteArea(glm::uvec2 area);
    glm::uvec2 pictureSize(const RenderRequest& wanted);
    void order(glm::uvec2 pictureArea);

    SessionOptions options_;
    ScenePictures pictures_;
    std::unique_ptr<Document> document_;
    std::vector<SavedCamera> savedCameras_;
    std::vector<std::string> unreadCameras_;  // JSON of those that could not be read
    std::optional<size_t> sceneCamera_;       // the view is this one's, also when it is animated
    core::Camera followed_;                   // as it was when it was taken
    size_t homeCamera_ = 0;
    std::optional<core::Camera> home_;  // where it began, when that is no camera of the scene
    ViewHistory history_;
    bool insideSolid_ = false, toldOfWall_ = false, toldOfStop_ = false;
    bool metered_ = false;                            // the first picture of this scene
    std::shared_ptr<const core::World> probedWorld_;  // for insideSolid_
    glm::dvec3 probedAt_{0};
    core::Camera soughtFrom_;             // the view that is to be left for what is found
    uint64_t seeking_ = 0, looking_ = 0;  // jobs of the lookout; 0: none
    std::shared_ptr<const Picture> picture_;
    Convergence convergence_;
    EqualTime equalTime_;

    std::shared_ptr<const Reference> reference_;
    std::shared_ptr<const core::World> referenceWorld_;  // what the reference shows
    double referenceTime_ = 0;                           // of the scene's animation
    core::Camera referenceCamera_;

    RenderRequest ordered_;
    uint64_t generation_ = 0, restarts_ = 0;
    double now_ = 0, movedAt_ = -1e9;
    // Of what the window has for it; of a replayed picture until the camera moves
    glm::uvec2 area_{0}, fixedSize_{0};
    double areaSince_ = 0;
    bool unsettled_ = false;
    bool keepsSize_ = false;  // the picture has not followed the window: it is worth too much
    double sizedFor_ = 0;     // the scale of the size that was ordered last
    std::unique_ptr<PendingSaves> pendingSaves_;
    std::shared_ptr<const Picture> whole_;  // the newest picture of whole samples
    bool saveFailed_ = false;               // since save() was called last
    std::array<bool, 2> slotWants_{};       // its variance, which was not known when it was kept
    std::optional<KeptPicture> pendingReference_;  // waits for its variance
    std::filesystem::path exportPattern_;
    double savedSeconds_ = 0;                         // of rendering, of the present picture
    std::vector<std::weak_ptr<const void>> saved_;    // pictures and references
    float keptScale_ = 0;                             // of the letters, when this run has another
    std::unique_ptr<SettingsKeeper> settingsKeeper_;  // none where none are kept
    std::unique_ptr<Replay> pendingReplay_;
    bool sameScene_ = false;  // what is being loaded is the scene on show with another environment

    uint64_t loadGeneration_ = 0, takenLoad_ = 0, referenceGeneration_ = 0;
    // Of each Work: its run that was seen last, and when that began, counted in beginnings
    std::array<uint64_t, kWorks> seenRun_{}, begun_{};
    uint64_t beginnings_ = 0;
    uint64_t toldLoader_ = 0, toldCore_ = 0, toldSaver_ = 0, toldRendering_ = 0;

    // Threads last: they end before what their jobs look at.
    std::shared_ptr<core::Mailbox<Loaded>> loadedBox_;
    std::shared_ptr<core::Mailbox<Reference>> referenceBox_;
    std::shared_ptr<SaveQueue> saves_;
    std::shared_ptr<core::Mailbox<Found>> foundBox_;
    std::shared_ptr<core::Mailbox<LookedAround>> aroundBox_;
    core::Worker loader_, core_, saver_, lookout_;
    PictureJudge judge_;
    RenderThread renderThread_;
};

}  // namespace app
