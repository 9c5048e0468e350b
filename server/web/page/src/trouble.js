// Says in the page what keeps it from starting, or what went wrong in it: an exception, or a file that did not come. A script of its
// own, in words that old browsers read, because it runs where the others do not.

(function () {
  var told = false;
  var texts = 'TEXTS';  // by language; the build writes them
  var own = texts[(navigator.language || '').slice(0, 2).toLowerCase()] || texts.en;
  try {
    own = texts[localStorage.getItem('feltwire-language')] || own;
  } catch (error) {
    // The browser keeps nothing.
  }

  /** @param {string} what went wrong; only the first is told, since others often follow from it */
  function tell(what) {
    if (document.readyState === 'loading') {
      document.addEventListener('DOMContentLoaded', function () { tell(what); });
      return;
    }
    var state = document.getElementById('state');
    if (told || !state) return;
    told = true;
    if (!state.hasAttribute('data-state')) {  // The page has not said anything of itself yet.
      state.setAttribute('data-state', 'failed');
      state.querySelector('span').textContent = own['app.failed'].replace('{what}', function () { return what; });
    } else if (state.getAttribute('data-state') !== 'failed') {
      var log = document.getElementById('log');
      log.hidden = false;
      log.setAttribute('data-level', 'error');
      log.querySelector('span').textContent = own['app.wrong'].replace('{what}', function () { return what; });
    }
  }

  window.addEventListener('error', function (event) {
    var file = event.target && (event.target.src || event.target.href);
    if (file) {
      if (/^(SCRIPT|LINK)$/.test(event.target.tagName)) tell(own['app.missing'].replace('{file}', function () { return file; }));
    } else if (!/^ResizeObserver loop/.test(event.message)) {  // This one only says that a size is heeded a frame later.
      tell((event.message || own['app.nameless']).replace(/^Uncaught /, '').replace(/\.?$/, '.'));
    }
  }, true);
  window.addEventListener('unhandledrejection', function (event) {
    tell(String((event.reason && event.reason.message) || event.reason).replace(/\.?$/, '.'));
  });
})();
