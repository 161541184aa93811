// The frame in the page's address: read once from #frame=52 or ?frame=52, written to the hash whenever a still is reached.

/** Follows the option `sync_url`; returns a function that stops. */
export function syncAddress(player) {
  const read = () => {
    if (!player.options.sync_url) return;
    const frame = frameIn(location.hash.slice(1)) ?? frameIn(location.search.slice(1));
    if (frame !== null) player.seek(frame);
  };
  const write = () => {
    if (!player.options.sync_url || player.options.playing) return;
    const rest = new URLSearchParams(location.hash.slice(1));
    rest.set("frame", player.frame);
    history.replaceState(history.state, "", `#${rest}`);
  };
  const onOption = ({ detail }) => { if (detail.name === "sync_url") read(); };
  read();
  player.addEventListener("settle", write);
  player.addEventListener("option", onOption);
  window.addEventListener("hashchange", read);
  return () => {
    player.removeEventListener("settle", write);
    player.removeEventListener("option", onOption);
    window.removeEventListener("hashchange", read);
  };
}

function frameIn(text) {
  const value = new URLSearchParams(text).get("frame");
  return /^\d+$/.test(value ?? "") ? Number(value) : null;
}
