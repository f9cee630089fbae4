#pragma once
// Blinded cases: datasets of the MuJoCo robot whose labels are encrypted. Effect and
// strength are drawn, and independently of them the experiment (of those in which the effect can
// act at all), streams, rates, noise and number of trials. Folder names are random; labels go into
// an encrypted file, their salted hash (the commitment) beside it, key and salt into a file of
// their own outside the folder of the datasets.
//
// Strength: the gap between the robot with and without the effect, noise-free, in noise floors
// (trials.h), is drawn from log-uniform [1, 20] and met by a search over the parameter. What is
// recorded leaves out the part that shifts of the streams' clocks and other starts of the joints
// explain, since nobody knows either; a case of less than 0.7 noise floors is drawn again. A case's
// true parameter is what a static or swept test of the MuJoCo robot shows (static_tests.h), not
// what was typed.
//
// A group is a case of two or three datasets: one robot (off its files by the same draw), one
// effect of the same strength, other experiments. Its folder holds datasets set_1, set_2, ...; that
// of any other case is a dataset itself.
//
// What can act at one joint alone ("friction@elbow") is drawn as often as what acts on all of them;
// which joint, is drawn then.
//
// A batch that was interrupted goes on with `resume`: what is finished stands in KEY.journal,
// beside the key and with labels in it, until the batch is whole. A resumed batch has the bytes of
// one that was left alone.
//
// Left and right legs: a draw in which they diverge by 20 mrad is left out and listed (`diverged`),
// unless an effect of it is one-sided or there is none: on the inactive plan, where the rear legs
// are near their shortest, and on feet that slip, their common way is unstable, and the case then
// holds more than its label says.
//
// Equivalent effects: those that at some strength, with shifts of each stream's clock, show on this
// robot what the true one shows, to within a log Bayes factor of 3 over all trials
// (equivalence.cpp).

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "jaculus/core/tasks.h"

namespace jaculus::testbed {

/// A push that was there once in every trial.
struct TrueEvent {
  std::string joint;            ///< planar joint; "base" for the body
  double from = 0.0, to = 0.0;  ///< [s], trial time
  double peak = 0.0;            ///< signed [N m], of the body [N]
};

/// What is true of a case.
struct CaseLabel {
  std::string case_id;
  /// "single", "several" (two or three), "pair", "none", "outside", "mixed", "event"
  std::string kind;
  std::vector<std::string> effects;  ///< of outside the generator's own names
  /// of a mixed case: what acts beside `effects` and is in no catalogue
  std::vector<std::string> beside;
  /// of each of `effects`, then of `beside`, alone [noise floors]
  std::vector<double> strengths;
  double legs_apart = 0.0;  ///< by how much left and right motors part at most [rad]
  /// an effect each, as measured; NaN: has no counterpart
  std::vector<std::vector<double>> parameters;
  double strength_in_noise_floors = 0.0;  ///< beyond what clocks and starts may do, as measured
  /// draws before it that were left out because left and right legs diverge (trials.h)
  std::vector<std::string> diverged;
  std::vector<std::string> equivalent;
  std::string component;
  std::string experiment;  ///< "leap aerotail_V7.csv duty"; of a group several, with " + "
  int trials = 0;          ///< of all datasets together
  int datasets = 1;        ///< more than one: a group
  std::vector<TrueEvent> events;
};

struct BlindingSpec {
  int singles = 0, none = 0, pairs = 0, outside = 0;
  int mixed = 0;    ///< an effect of the catalogue and something outside it
  int several = 0;  ///< two or three effects of the catalogue
  int events = 0;   ///< a push, once a trial
  int groups = 0;   ///< single effects, in two or three datasets each
  /// Robots are off their files by their tolerances, sensors have noise of every kind, and no draw
  /// is left out because left and right legs part.
  bool clutter = false;
  std::vector<std::string> withheld;  ///< outside effects and pushes that are not drawn
  std::uint64_t seed = 1;
  /// folders of the robots; each plays what it can: plans, a drop and a bench where it has a tail
  std::vector<std::filesystem::path> robots;
  /// leaps; each is played by the first robot all of whose motors it has
  std::vector<std::filesystem::path> plans;
  std::filesystem::path out;
  std::filesystem::path key;  ///< file of key and salt; not within `out`
  std::string provenance;     ///< of the batch: seed or commit
  int jobs = 0;
  bool resume = false;  ///< go on with what an interrupted run has finished
  std::function<void(const TaskProgress&)> progress = {};
  std::function<void(const std::string&)> notice = {};  ///< as of TaskOptions
  /// as of TaskOptions; what it keeps holds labels, so its folder must not lie in `out`
  std::shared_ptr<const Executor> executor = {};
};

/// Draws and plays all cases, writes a folder a case, labels.sealed and commitment.txt into `out`,
/// and the key. Same seed and plans: same datasets, byte for byte. InputError where `out` is not
/// empty or `key` lies in it, where nothing of a kind that is asked for can be drawn, and where a
/// journal is there that is not to be gone on with or is of another batch.
std::vector<std::string> blind_cases(const BlindingSpec& spec);

/// Ids of a blinded batch, sorted; a group has one.
std::vector<std::string> blinded_ids(const std::filesystem::path& folder);

/// Folders of a case's datasets: its own, or those of its sets.
std::vector<std::filesystem::path> case_datasets(const std::filesystem::path& case_folder);

/// Opens the labels. InputError where key, labels and commitment do not belong together.
std::vector<CaseLabel> open_labels(const std::filesystem::path& folder,
                                   const std::filesystem::path& key,
                                   std::string* provenance = nullptr);

/// Seed of a final batch from a commit's hash (40 hex digits): the first 63 bits of its BLAKE2b.
/// InputError for anything else.
std::uint64_t seed_of_commit(const std::string& hash);

}  // namespace jaculus::testbed
