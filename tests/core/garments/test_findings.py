"""What was worn is told with the patches that it carried."""

import numpy as np

from w2w.core.clip_files import WORK
from w2w.core.garments.cover import FITTED, Cover, save_covers
from w2w.core.garments.findings import caught_content, caught_sentences, garment_content, garment_sentence
from w2w.core.patches.patches import sample_patches


def test_it_names_the_patches_and_their_regions(tmp_path, bundled_body):
    patches = sample_patches(bundled_body, n=12)
    (tmp_path / WORK).mkdir()
    chosen = np.array([2, 5])
    own = Cover(chosen, np.zeros((2, 3), dtype=int), np.tile(np.eye(3), (2, 1, 1)))
    save_covers(tmp_path / FITTED, {"tshirt": own}, [""])
    content = garment_content(tmp_path, ("tshirt",), patches)
    regions = sorted({patches.regions[2], patches.regions[5]})
    assert content == {"tshirt": {"patches": [2, 5], "regions": regions}}
    sentence = garment_sentence(content, 12)
    assert sentence.startswith("Of 12 patches 2 on tshirt and 10 on the skin.")
    assert "not yet been checked against worn garments" in sentence


def test_where_nothing_is_worn_nothing_is_said(tmp_path):
    assert garment_content(tmp_path, (), None) == {}
    assert garment_sentence({}, 12) == ""


def test_clips_in_which_cloth_caught_are_named_and_counted():
    fine = caught_content({"tshirt": 0}, 90)
    assert fine == {}
    bad = caught_content({"tshirt": 7, "trousers": 0}, 90)
    assert bad == {"cloth_caught": {"tshirt": 7}, "cloth_frames": 90}
    (sentence,) = caught_sentences([("walk", fine), ("kick", bad)])
    assert sentence == (
        "In kick cloth caught on the body, stretched to more than 2 times its length: tshirt in 7 of 90 "
        "frames: do not trust what its sensors feel there"
    )
    assert caught_sentences([("walk", fine)]) == []


def test_many_clips_are_not_all_named():
    bad = caught_content({"tshirt": 7}, 90)
    sentences = caught_sentences([(f"kick{number}", bad) for number in range(5)])
    assert len(sentences) == 4
    assert sentences[-1] == "Cloth caught in 2 more clips: see cloth_caught in summary.json"
