// Says in the page what keeps it from starting, or what went wrong in it: an exception, or a file that did not come. A script of its
// own, in words that old browsers read, because it runs where the others do not.

(function () {
  var told = false;

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
      state.querySelector('span').textContent = 'This page could not start: ' + what + ' Reload it; if that does not help, try another browser.';
    } else if (state.getAttribute('data-state') !== 'failed') {
      var log = document.getElementById('log');
      log.hidden = false;
      log.setAttribute('data-level', 'error');
      log.querySelector('span').textContent = 'Something went wrong in this page, and it may show less than it should: ' + what + ' Reload it.';
    }
  }

  window.addEventListener('error', function (event) {
    var file = event.target && (event.target.src || event.target.href);
    if (file) {
      if (/^(SCRIPT|LINK)$/.test(event.target.tagName)) tell(file + ' did not come.');
    } else if (!/^ResizeObserver loop/.test(event.message)) {  // This one only says that a size is heeded a frame later.
      tell((event.message || 'an error without a name').replace(/^Uncaught /, '').replace(/\.?$/, '.'));
    }
  }, true);
  window.addEventListener('unhandledrejection', function (event) {
    tell(String((event.reason && event.reason.message) || event.reason).replace(/\.?$/, '.'));
  });
})();
