"""The operator page: see the robot from any browser, drive it, and speak to it.

beat ──▶ Feed ──▶ Desk ──▶ pages (WebSockets)      on the server's thread
Inbox ◀── commands, stop ◀── Desk ◀── pages
Hearing ◀── BrowserMicrophone ◀── sound of the page that drives
"""
