"""The released tokenizer against its own numbers (golden/tm2t_vq): forward, losses, three updates, averages."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from safetensors.torch import load_file
from torch import Tensor

from engines.tm2t.official import discriminator_of, vq_losses, vq_update
from engines.tm2t.official_weights import from_official, tokenizer_of
from engines.tm2t.tokenizer import AveragedCodebook, perplexity
from tests.engines.action2motion.golden import cases, close, tensors

pytestmark = pytest.mark.golden

FORWARD, LOSS, GRADIENT, AFTER = 1e-5, 1e-6, 1e-5, 2e-4


def beside(path, ending: str) -> dict[str, Tensor]:
    """The weights that belong to a file of numbers."""
    kind = path.stem.partition("_")[0]
    return load_file(path.with_name(f"{kind}_weights{ending}.safetensors"))


def tags(arrays: dict[str, Tensor]) -> list[str]:
    return [name.removesuffix("_motion") for name in arrays if name.endswith("_motion")]


@pytest.mark.parametrize("path", cases("tm2t_vq", "*_forward.npz"))
def test_golden_there_and_back(path) -> None:
    a, net = tensors(path), tokenizer_of(beside(path, "")).eval()
    assert len(tags(a)) >= 3
    for tag in tags(a):
        motion = a[f"{tag}_motion"]
        made, coded = net(motion)
        assert torch.equal(coded.codes, a[f"{tag}_indices"].long()), tag
        assert torch.equal(net.encode(motion).flatten(), a[f"{tag}_map2index_flat"].long()), tag
        found = {
            "pre_latents": coded.latents, "quantised_st": coded.passed, "codebook_entry": coded.entries,
            "recon": made, "recon_from_indices": net.decode(coded.codes),
        }  # fmt: skip
        for name, value in found.items():
            close(value, a[f"{tag}_{name}"], FORWARD, f"{tag} {name}")
        terms = vq_losses(motion[:, : made.shape[1]], made, coded)
        found = {
            "loss_embedding_total": terms["embedding"], "loss_rec_l1": terms["reconstruction"],
            "loss_codebook_term": (coded.entries - coded.latents).square().mean(),
            "loss_commit_term_before_beta": (coded.entries - coded.latents).square().mean(),
            "perplexity": perplexity(coded.codes, len(net.codebook.weight)),
        }  # fmt: skip
        for name, value in found.items():
            if f"{tag}_{name}" in a:  # where the frames are no multiple of four, the release has no L1
                torch.testing.assert_close(value, a[f"{tag}_{name}"], rtol=LOSS, atol=1e-7, msg=f"{tag} {name}")
    made, coded = net(a["T64_motion"])
    embedding = vq_losses(a["T64_motion"], made, coded, beta=0.25)["embedding"]
    torch.testing.assert_close(embedding, a["beta025_loss_embedding_total"], rtol=LOSS, atol=0)


@pytest.mark.parametrize("path", cases("tm2t_vq", "*_enc263.npz"))
def test_golden_encoder_of_263_features(path) -> None:
    a, net = tensors(path), tokenizer_of(beside(path, "_enc263")).eval()
    latents = net.latents(a["motion"])
    coded = net.codebook(latents)
    close(latents, a["pre_latents"], FORWARD)
    assert torch.equal(coded.codes, a["indices"].long())
    embedding = vq_losses(latents, latents, coded)["embedding"]
    torch.testing.assert_close(embedding, a["loss_embedding_total"], rtol=LOSS, atol=0)
    torch.testing.assert_close(perplexity(coded.codes, len(net.codebook.weight)), a["perplexity"], rtol=LOSS, atol=0)


@pytest.mark.parametrize("path", cases("tm2t_vq", "*_train_steps.npz"))
def test_golden_three_updates(path) -> None:
    a, state = tensors(path), beside(path, "")
    net, judge = tokenizer_of(state).train(), discriminator_of(state).train()
    rate = float(a["lr"])
    optimisers: list[torch.optim.Optimizer] = [
        torch.optim.Adam(part.parameters(), lr=rate) for part in (net.encoder, net.codebook, net.decoder)
    ]
    judging = torch.optim.Adam(judge.parameters(), lr=rate)
    for at in range(3):
        adversarial = float(a["lambda_adv"]) if f"s{at}_loss_D" in a else 0.0
        made = vq_update(net, judge, a[f"s{at}_motion"], optimisers, judging, adversarial)
        found = {
            "loss_G": made.total, "loss_G_rec_mot": made.terms["reconstruction"],
            "loss_G_emb": made.terms["embedding"], "perplexity": perplexity(made.codes, len(net.codebook.weight)),
            "loss_G_adv": made.terms.get("adversarial"), "loss_D": made.terms.get("discriminator"),
        }  # fmt: skip
        for name, value in found.items():
            if value is not None:
                # after the first update the weights themselves agree only as far as Adam lets them
                torch.testing.assert_close(value, a[f"s{at}_{name}"], rtol=LOSS if at == 0 else 1e-4, atol=1e-6)
        names = {
            "grad_codebook": net.codebook.weight.grad, "grad_enc_main0_weight": net.encoder.layers[0].weight.grad,
            "grad_dec_last_weight": net.decoder.layers[-1].weight.grad,
        }  # fmt: skip
        for name, gradient in names.items():
            expected = a[f"s{at}_{name}"]
            assert gradient is not None
            scale = GRADIENT if at == 0 else 5e-3
            close(gradient, expected, scale * float(expected.abs().max()), f"{at} {name}")
        after = {
            "codebook_after": net.codebook.weight, "enc_main0_weight_after": net.encoder.layers[0].weight,
            "dec_last_bias_after": net.decoder.layers[-1].bias,
        }  # fmt: skip
        for name, value in after.items():
            # where a file has the same weights after every update, they were written down after the last
            if at == 2 or not torch.equal(a[f"s{at}_{name}"], a[f"s2_{name}"]):
                close(value, a[f"s{at}_{name}"], AFTER, f"{at} {name}")
    close(judge.layers.state_dict()["0.weight"], a["s2_disc_main0_weight_after"], AFTER)
    for name in [name for name in a if name.startswith("s2_disc_after.")]:
        ours = name.removeprefix("s2_disc_after.main.")
        close(judge.layers.state_dict()[ours], a[name], AFTER, name)


@pytest.mark.parametrize("path", cases("tm2t_vq", "*_ema_variant.npz"))
def test_golden_averaged_codebook(path) -> None:
    a = tensors(path)
    codes, size = a["init.embedding.weight"].shape
    book = AveragedCodebook(codes, size, decay=0.99, release=True).train()
    names = {"weight": "weight", "uses": "cluster_size", "sums": "embed_avg"}
    book.load_state_dict({ours: a[f"init.embedding.{theirs}"] for ours, theirs in names.items()})
    for at in ("s0", "s1", "s2", "eval"):
        book.train(at != "eval")
        coded = book(a[f"{at}_z"])
        assert torch.equal(coded.codes.flatten(), a[f"{at}_indices"].long())
        loss = 0.5 * (coded.entries - coded.latents).square().mean()
        torch.testing.assert_close(loss, a[f"{at}_loss"], rtol=1e-5, atol=1e-7)
        torch.testing.assert_close(perplexity(coded.codes, codes), a[f"{at}_perplexity"], rtol=1e-5, atol=0)
        close(coded.passed, a[f"{at}_zq_st" if at != "eval" else "eval_zq"], FORWARD)
        for ours, theirs in names.items():
            if at != "eval":
                close(book.state_dict()[ours], a[f"{at}_after.embedding.{theirs}"], FORWARD, f"{at} {theirs}")


@pytest.mark.parametrize("path", cases("tm2t_vq", "*_weights.safetensors"))
def test_golden_every_weight_has_a_place(path) -> None:
    state = load_file(path)
    own = {name: value for name, value in state.items() if not name.startswith("discriminator.")}
    renamed = from_official(own)
    assert len(renamed) == len(own)
    made = tokenizer_of(state).state_dict()
    assert set(made) == set(renamed)
    for name, value in renamed.items():
        np.testing.assert_array_equal(made[name], value)
