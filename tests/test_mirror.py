# SPDX-License-Identifier: GPL-3.0-or-later
"""Tests mirror the packages: w2w/core/imu/sensor.py is tested by tests/core/imu/test_sensor.py."""

from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
TREES = {"blender_addon/w2w": "tests", "headless": "tests/headless", "studies": "tests/studies"}
UNMIRRORED = {  # tested by the tests of what uses them, or of the road they are on
    "tests": "api command_line loading ranking",
    "tests/core": "filtering results_folder study",
    "tests/core/adopt": "mesh_files pickles registration rest_pose topology",
    "tests/core/body": "landmarks region_limbs region_trunk skeleton",
    "tests/core/exports": "arrays bids biomechanics parquet pose_packs study_signals",
    "tests/core/findings": (
        "advice_content best_regions counts finished_study label_notes new_folder own_placements summary"
    ),
    "tests/core/imu": "errors formats gaps presets quantities sensor_fields text_tables vendor_formats",
    "tests/core/keypoints": "facts joint_sets limbs naming paths pose_text smoothing",
    "tests/core/motion": "joint_files repair source",
    "tests/core/ranking/classifiers/multi3net": "examples group scores settings training",
    "tests/core/selection": "terms",
    "tests/headless": "app console options run start study_options temporary w2w",
    "tests/headless/commands": "demo execute sensors status",
    "tests/headless/reports": ("comparison console_tables pictures redraw report_data signal_figure"),
    "tests/headless/runs": ("blender_worker clip folder guard load_clip monitor own_sensor study"),
    "tests/scene": (
        "evaluated fast_path fcurves gltf load output packing patches playback reshape scene_motion "
        "study_file study_record takes"
    ),
    "tests/scene/garments": "wear",
    "tests/studies/commands": (
        "consoles demo_library study_mixamo study_paper study_rehab study_truth sweep tables"
    ),
    "tests/studies/comparisons": (
        "dsads figures paired posture protocol_report report site_simulator truth utd"
    ),
    "tests/studies/datasets": "broad clock dsads gait gait_sites",
    "tests/studies/experiments": (
        "band expected_at_sites gait gait_limits garments lever_arms noise_by_clips noise_draws "
        "rehab_counterparts truth_draws vigour_views why_figure why_rows why_views"
    ),
    "tests/studies/placements": "activity_groups score_text trend_table",
    "tests/studies/rehab": "arm_raise clips curves one_leg pose session sit_to_stand skeleton stairs style",
    "tests/studies/sweep": "figure maps",
    "tests/studies/validation": "correlation dsads mhad",
    "tests/ui": (
        "advice drawing garment_properties headless_door on_character operators overlay "
        "own_placement_panel own_sensor_panel panels placement_panels properties "
        "result_panels results rows scores sensor_properties signal_cache source_view state step1_body "
        "step2_motions step3_patches step4_signals step5_ranking step_panel text updates"
    ),
}


def test_every_module_has_a_test_of_its_name():
    found = {}
    for tree, tests in TREES.items():
        for module in (ROOT / tree).rglob("[!_]*.py"):
            folder = Path(tests, module.relative_to(ROOT / tree).parent)
            if "presets/" not in module.as_posix() and not (ROOT / folder / f"test_{module.name}").exists():
                found.setdefault(folder.as_posix(), set()).add(module.stem)
    expected = {folder: set(names.split()) for folder, names in UNMIRRORED.items()}
    assert found == expected, "write a test of the module's name, or take the module off the list"
