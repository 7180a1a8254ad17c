# SPDX-License-Identifier: MIT
"""python3 -m unittest discover training/tests"""
import sys
import tempfile
import unittest
from pathlib import Path

import cv2
import numpy as np
import torch

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import benchmark
import data
import detectors
import export
import fetch_free
import model


def line(column, rows=20, height=30, width=40):
    mask = np.zeros((height, width), bool)
    mask[5:5 + rows, column] = True
    return mask


class Matching(unittest.TestCase):
    def test_lines_within_the_radius_match_and_farther_ones_do_not(self):
        self.assertEqual(benchmark.count_matches(line(10), line(12), 2), 20)
        self.assertEqual(benchmark.count_matches(line(10), line(13), 2), 0)

    def test_a_pixel_is_used_once(self):
        doubled = line(10) | line(11)
        self.assertEqual(benchmark.count_matches(doubled, line(10), 3), 20)
        self.assertEqual(benchmark.count_matches(line(10), doubled, 3), 20)

    def test_the_matching_is_a_largest_one(self):
        # The nearest pairs first would take the middle pixel's only partner.
        found, truth = np.zeros((3, 9), bool), np.zeros((3, 9), bool)
        found[1, [0, 3]] = True
        truth[1, [2, 5]] = True
        self.assertEqual(benchmark.count_matches(found, truth, 2), 2)

    def test_as_many_as_scipy_finds(self):
        from scipy.sparse import csr_matrix
        from scipy.sparse.csgraph import maximum_bipartite_matching
        rng = np.random.default_rng(3)
        for share in (0.02, 0.1, 0.2):
            found, truth = rng.random((2, 40, 50)) < share
            a, b = np.argwhere(found), np.argwhere(truth)
            near = ((a[:, None] - b[None]) ** 2).sum(2) <= 2.3 ** 2
            want = (maximum_bipartite_matching(csr_matrix(near), "column") >= 0).sum()
            self.assertEqual(benchmark.count_matches(found, truth, 2.3), want)

    def test_scores_of_a_perfect_answer_are_one(self):
        counts = benchmark.counts_of([line(10), line(10)], line(10))
        result = benchmark.summary([counts], np.array([0.3, 0.6]))
        self.assertAlmostEqual(result["ODS"], 1)
        self.assertAlmostEqual(result["OIS"], 1)


class Thinning(unittest.TestCase):
    def test_a_band_becomes_a_line(self):
        band = np.zeros((20, 40), bool)
        band[8:13, 4:36] = True
        thin = benchmark.thin(band)
        self.assertTrue((thin.sum(0) <= 1).all())
        self.assertGreater(thin.sum(), 24)

    def test_a_crest_survives_suppression_and_its_flanks_do_not(self):
        x = np.arange(60)
        strength = np.tile(np.exp(-((x - 30) / 3.0) ** 2), (50, 1)).astype(np.float32)
        kept = benchmark.suppress(strength)[10:-10] > 0.5
        self.assertTrue(kept[:, 30].all())
        self.assertEqual(np.count_nonzero(kept[:, :28]) + np.count_nonzero(kept[:, 33:]), 0)


class Network(unittest.TestCase):
    def test_opencv_gives_what_torch_gives(self):
        torch.manual_seed(1)
        net = model.EdgeNet()
        for module in net.modules():
            if isinstance(module, torch.nn.BatchNorm2d):
                module.running_mean.normal_(0, 0.1)
                module.running_var.uniform_(0.5, 1.5)
        folded = model.merged(net)
        x = torch.randn(1, 3, 64, 96)
        with torch.no_grad():
            both = net.eval()(x)
            self.assertLess((both.mean(1, keepdim=True) - folded(x)).abs().max(), 1e-5)
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "net.onnx"
            export.write_onnx(folded, path)
            self.assertLess(export.largest_difference(folded, path), export.LARGEST_DIFFERENCE)

    def test_the_batch_of_a_step_is_the_same_each_time(self):
        rng = np.random.default_rng(0)
        bgr = rng.integers(0, 256, (240, 320, 3), dtype=np.uint8)
        sample = data.Sample(bgr, bgr[..., 0], bgr[..., 1], True)
        first, second = (data.batch([sample], 2, 96, 0.3, 1, 7) for _ in range(2))
        self.assertTrue(np.array_equal(first[0], second[0]))
        self.assertTrue(torch.equal(first[1], second[1]))


class FreeImages(unittest.TestCase):
    def test_they_fill_a_batch_without_labels(self):
        teacher = Path(__file__).resolve().parents[2] / "models/edvo_edges.toml"
        with tempfile.TemporaryDirectory() as folder:
            cv2.imwrite(f"{folder}/square.png",
                        cv2.rectangle(np.zeros((200, 300, 3), np.uint8), (90, 60), (210, 140),
                                      (255, 255, 255), -1))
            samples = data.load(None, Path(folder) / "cache", [str(teacher)], folder)
        _, drawn, said, labelled = data.batch(samples, 3, 160, 0.3, 1, 0)
        self.assertFalse(labelled.any() or drawn.any())
        self.assertGreater(said.max(), 0.5)

    def test_teachers_together_answer_with_the_mean_of_their_logits(self):
        bgr = np.zeros((6, 8, 3), np.uint8)
        both = detectors.Together([])
        both.parts = [lambda x: np.full(x.shape[:2], 0.9),
                      detectors.Enlarged(lambda x: np.full(x.shape[:2], 0.1), 1.5)]
        np.testing.assert_allclose(both(bgr), np.full((6, 8), 0.5), atol=1e-6)

    def test_the_list_names_every_file_once_with_licence_and_author(self):
        rows = fetch_free.listed()
        self.assertEqual(len({fetch_free.name_of(r) for r in rows}), len(rows))
        self.assertTrue(all(len(r["commit"]) == 40 and r["licence"] and r["author"] for r in rows))


if __name__ == "__main__":
    unittest.main()
