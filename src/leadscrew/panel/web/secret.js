// The secret that gives control back to this page after a lost connection or a reload. Browsers copy the memory of a
// tab into its duplicate: two pages must never hold one secret, or control would go to and fro between them.

const KEY = "leadscrew.secret";
const ANSWER_MS = 200; // another page of this browser answers within a few milliseconds

function made() {
  const bytes = crypto.getRandomValues(new Uint8Array(16));
  return Array.from(bytes, (byte) => byte.toString(16).padStart(2, "0")).join("");
}

/** Whether another page that is open now says that the secret is its own. */
function isHeld(channel, secret) {
  return new Promise((resolve) => {
    channel.onmessage = ({ data }) => { if (data?.mine === secret || data?.whose === secret) resolve(true); };
    channel.postMessage({ whose: secret });
    setTimeout(() => resolve(false), ANSWER_MS);
  });
}

/** This page's secret: that of before a reload, a new one in a new tab and in one that was duplicated. */
export async function ownSecret(store = globalThis.sessionStorage, channel = new BroadcastChannel(KEY)) {
  let found = null;
  try {
    found = store.getItem(KEY);
  } catch { /* a browser that keeps nothing */ }
  const secret = found && !(await isHeld(channel, found)) ? found : made();
  try {
    store.setItem(KEY, secret);
  } catch { /* likewise */ }
  channel.onmessage = ({ data }) => { if (data?.whose === secret) channel.postMessage({ mine: secret }); };
  return secret;
}
