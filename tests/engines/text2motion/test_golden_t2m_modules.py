"""The released networks against their own numbers (golden/t2m_modules): modules, training pass, generation, lengths."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from safetensors.torch import load_file
from torch import Tensor

from engines.metrics import official_texts
from engines.text import tags
from engines.text.glove import GloVe
from engines.text2motion import official
from engines.text2motion.losses import autoencoder_terms
from engines.text2motion.model import generate
from engines.text2motion.networks import time_to_arrival
from engines.text2motion.official_weights import autoencoder_of, lengths_of, our_name, vae_of
from tests.engines.action2motion.golden import cases, close, tensors

pytestmark = pytest.mark.golden

TOPIC = "t2m_modules"
FORWARD, LOSS, GRADIENT = 2e-5, 1e-5, 1e-4
COMP = cases(TOPIC, "*_comp.npz")


def weights(path) -> dict[str, Tensor]:
    return load_file(path.with_suffix(".safetensors"))


def networks(path):
    state = weights(path)
    return vae_of(state).eval(), autoencoder_of(state).eval()


def noise(stored: Tensor) -> Tensor:
    """(S, B, Z) -> (B, S, Z)."""
    return stored.transpose(0, 1)


@pytest.mark.parametrize("path", COMP)
def test_golden_autoencoder(path) -> None:
    a, (_, net) = tensors(path), networks(path)
    codes = net.encode(a["motions"])
    close(codes, a["movement_latents"], FORWARD)
    made = net.decode(codes)
    close(made, a["movement_decoded"], FORWARD)
    close(made, a["ae_recon"], FORWARD)
    close(official.start(net, len(codes)), a["movement_start_token"], FORWARD)
    terms = autoencoder_terms(a["motions"], made, codes, 1.0, 1.0)
    for name, told in {"reconstruction": "rec", "sparsity": "sparsity", "smoothness": "smooth"}.items():
        torch.testing.assert_close(terms[name], a[f"ae_loss_{told}"], rtol=LOSS, atol=0)
    total = torch.stack(list(autoencoder_terms(a["motions"], made, codes, 0.001, 0.001).values())).sum()
    torch.testing.assert_close(total, a["ae_loss"], rtol=LOSS, atol=0)


@pytest.mark.parametrize("path", COMP)
def test_golden_single_networks(path) -> None:
    a, (net, _) = tensors(path), networks(path)
    read = net.reader(a["word_emb"], a["pos_ohot"], a["cap_lens"])
    close(read.words, a["text_word_hids"], FORWARD)
    close(read.sentence, a["text_hidden"], FORWARD)
    assert net.attention is not None
    seen, looked = net.attention(a["att_query"], net.attention.hold(read))
    close(seen, a["att_out"], FORWARD)
    close(looked[..., None], a["att_weights"], FORWARD)
    width = a["pos_enc_table"].shape[1]
    close(time_to_arrival(torch.arange(len(a["pos_enc_table"])), width), a["pos_enc_table"], FORWARD)
    close(time_to_arrival(a["pos_enc_fn_in"], a["pos_enc_fn_out"].shape[1]), a["pos_enc_fn_out"], FORWARD)
    memories = {"pri": net.prior, "post": net.posterior, "dec": net.generator}
    for name, part in memories.items():
        close(torch.stack(part.begin(read.sentence)), a[f"init_hidden_{name}"], FORWARD)
    arrival = time_to_arrival(a["step_tta"], net.sizes.latent_hidden)
    prior, after = net.prior(a["step_pri_in"], arrival, list(a["init_hidden_pri"]))
    close(prior.mean, a["step_pri_mu"], FORWARD)
    close(prior.logvar, a["step_pri_logvar"], FORWARD)
    close(prior.sample(a["step_pri_eps"]), a["step_pri_z"], FORWARD)
    close(torch.stack(after), a["step_pri_hidden"], FORWARD)
    arrival = time_to_arrival(a["step_tta"], net.sizes.motion_hidden)
    code, after = net.generator(a["step_dec_in"], arrival, list(a["init_hidden_dec"]))
    close(code, a["step_dec_out"], FORWARD)
    close(torch.stack(after), a["step_dec_hidden"], FORWARD)


def passed(path, kind: str) -> tuple[dict[str, Tensor], official.Forced, tuple]:
    a, (net, autoencoder) = tensors(path), networks(path)
    from_prior = kind == "evalprior"
    eps = noise(a["fwd_eps_pri" if from_prior else "fwd_eps_post"])
    made = official.forced(
        net, autoencoder, a["word_emb"], a["pos_ohot"], a["cap_lens"], a["motions"], a["m_lens"], eps,
        kind == "tf", from_prior,
    )  # fmt: skip
    return a, made, (net, autoencoder)


@pytest.mark.parametrize("path", COMP)
@pytest.mark.parametrize("kind", ["tf", "free", "evalprior"])
def test_golden_training_pass(path, kind: str) -> None:
    a, made, _ = passed(path, kind)
    close(made.told.codes, a[f"{kind}_movements"], FORWARD)
    close(made.motions, a[f"{kind}_motions"], FORWARD)
    for name, told in (("post", made.told.posterior), ("pri", made.told.prior)):
        close(noise(told.mean), a[f"{kind}_mu_{name}"], FORWARD)
        close(noise(told.logvar), a[f"{kind}_logvar_{name}"], FORWARD)
    assert made.told.weights is not None
    close(made.told.weights.transpose(1, 2), a[f"{kind}_att"], FORWARD)
    terms = official.losses(made, a["motions"], 1.5, 0.7, 0.01)
    names = {"motion": "mot_rec", "codes": "mov_rec", "kl": "kld", "total": "gen"}
    for name, told in names.items():
        assert terms[name].item() == pytest.approx(float(a[f"{kind}_loss_{told}"]), rel=LOSS), name


@pytest.mark.parametrize("path", COMP)
def test_golden_gradients(path) -> None:
    a, made, (net, autoencoder) = passed(path, "tf")
    official.losses(made, a["motions"], 1.5, 0.7, 0.01)["total"].backward()
    official.shorten(net, autoencoder)
    ours = dict(net.named_parameters()) | dict(autoencoder.named_parameters())
    stored = load_file(path.with_name(f"{path.stem}_grads.safetensors"))
    assert stored
    for name, expected in stored.items():
        gradient = ours[our_name(name)].grad
        assert gradient is not None, name
        size = float(expected.abs().max())
        torch.testing.assert_close(gradient, expected, rtol=GRADIENT, atol=GRADIENT * max(size, 1e-4), msg=name)
    told = {our_name(name) for name in stored}
    # the encoder is frozen; lower layers of prior and posterior are not heard
    unheard = [f"{part}.cells.{layer}." for part in ("prior", "posterior") for layer in range(net.sizes.layers - 1)]
    assert all(name in told or name.startswith(("encoder.", *unheard)) for name in ours)


@pytest.mark.parametrize("path", COMP)
@pytest.mark.parametrize("kind", ["same", "own"])
def test_golden_generation(path, kind: str) -> None:
    a, (net, autoencoder) = tensors(path), networks(path)
    read = net.reader(a["word_emb"], a["pos_ohot"], a["cap_lens"])
    units = a[f"gen_{kind}_m_lens"] // 4
    eps, start = noise(a[f"gen_{kind}_eps"]), official.start(autoencoder, len(units))
    steps, heat, last, priors, drawn = net.steps(read, units), [], start, [], []
    for at in range(eps.shape[1]):
        last, prior = steps.step(last, eps[:, at])
        priors.append(prior)
        drawn.append(prior.sample(eps[:, at]))
    for name, values in (
        ("mu_pri", [prior.mean for prior in priors]), ("logvar_pri", [prior.logvar for prior in priors]), ("z", drawn)
    ):  # fmt: skip
        close(torch.stack(values), a[f"gen_{kind}_{name}"], FORWARD)
    codes = generate(net.steps(read, units), start, eps, heat)
    close(codes, a[f"gen_{kind}_snippets"], FORWARD)
    close(torch.stack(heat, -1), a[f"gen_{kind}_att"], FORWARD)
    close(autoencoder.decode(codes), a[f"gen_{kind}_motions"], FORWARD)


@pytest.mark.parametrize("path", cases(TOPIC, "*_lenest.npz"))
def test_golden_length_estimator(path) -> None:
    a, net = tensors(path), lengths_of(weights(path)).eval()
    logits = net(a["word_emb"], a["pos_ohot"], a["cap_lens"])
    close(logits, a["logits"], FORWARD)
    close(logits.softmax(-1), a["probs"], FORWARD)
    loss = torch.nn.functional.cross_entropy(logits, a["m_lens"] // 4)
    torch.testing.assert_close(loss, a["ce_loss"], rtol=LOSS, atol=0)


@pytest.mark.parametrize("path", cases(TOPIC, "*_evaluator.npz"))
def test_golden_co_embedding(path) -> None:
    a = tensors(path)
    net = official_texts.OfficialCoEmbedding.load(path.with_suffix(".safetensors"))
    texts, motions = net.text(a["word_emb"], a["pos_ohot"], a["cap_lens"]), net.motion(a["motions"], a["m_lens"])
    order = official_texts.released_order(a["m_lens"])
    np.testing.assert_array_equal(order, a["sorted_order"])
    close(texts[order], a["text_embedding_sorted"], FORWARD)
    close(motions[order], a["motion_embedding_sorted"], FORWARD)
    close(motions[order], a["motion_embedding_only_sorted"], FORWARD)
    shift, margin = int(a["neg_shift"]), float(a["margin"])
    terms = official_texts.contrastive_terms(texts[order], motions[order], shift, margin)
    for name, told in (("positive", "loss_pos"), ("negative", "loss_neg")):
        assert float(terms[name]) == pytest.approx(float(a[told]), rel=LOSS)
    assert float(sum(terms.values())) == pytest.approx(float(a["loss"]), rel=LOSS)


@pytest.mark.parametrize("path", cases(TOPIC, "*_word_vectorizer.npz"))
def test_golden_words(path) -> None:
    with np.load(path) as stored:
        a = dict(stored)
    words = GloVe([str(word) for word in a["vocab"]], a["vocab_vectors"])
    names = dict(zip(a["pos_names"].tolist(), tags.TAGS, strict=True))
    kinds = {"Loc_VIP": "direction", "Body_VIP": "body part", "Obj_VIP": "object", "Act_VIP": "action",
             "Desc_VIP": "manner", "OTHER": "OTHER"}  # fmt: skip
    assert all(kinds.get(theirs, theirs) == ours for theirs, ours in names.items())
    for theirs, ours in kinds.items():
        if ours in tags.KINDS:
            assert set(tags.RELEASED[ours]) == set(a[f"vip_{theirs}"].tolist())
    for token, vector, one_hot in zip(a["tokens"], a["vectors"], a["pos_onehot"], strict=True):
        word, _, part = str(token).rpartition("/")
        np.testing.assert_allclose(words.vector(word), vector, atol=1e-6)
        np.testing.assert_array_equal(tags.one_hot(np.array(tags.released_tag(word, part, word in words))), one_hot)
